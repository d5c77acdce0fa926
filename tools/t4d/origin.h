#pragma once

#include <string>
#include <vector>

#include "t4d/file.h"
#include "t4d/mesh.h"
#include "t4d/surface.h"

namespace t4d::tools {

/// The middle of the bounds, rounded to a few digits, no coarser than a tenth of their largest
/// extent; zero for empty bounds.
model::Point3 roundCenterOf(const model::Bounds3& bounds);

/// The place of a .t4d file's origin in the original coordinates: `details.origin` of its metadata,
/// zero if there is none.
model::Point3 originOf(const formats::Metadata& metadata);

/// `detailsJson` with `origin` in it; as it is if that is zero.
std::string withOrigin(const std::string& detailsJson, const model::Point3& origin);

/// How to place a solid of this file in glTF: its length unit in metres and its up axis. An unknown
/// unit is taken as metres, with a notice.
formats::GltfPlacement placementOf(const formats::Metadata& metadata,
                                   std::vector<std::string>& notices);

}  // namespace t4d::tools
