#pragma once

#include <string>

#include "t4d/mesh.h"

namespace t4d::tools {

/// Fails if the solid would be so far from the origin, for its width, that doubles flatten it, or
/// so small that products of its extents vanish. Returns whether doubles are much coarser where
/// it will be than they need be for its size, so that parts of it may become flat.
Result<bool> checkMovedBounds(const model::Bounds3& bounds, const model::TimeSpan& span,
                              const model::Transform& transform, const std::string& where);

}  // namespace t4d::tools
