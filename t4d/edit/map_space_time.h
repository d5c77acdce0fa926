#pragma once

#include <set>
#include <string>

#include <Eigen/Core>

#include "t4d/edit/cut_into_slabs.h"
#include "t4d/model/slab.h"

namespace t4d::edit {

struct MappedMesh {
  CutMesh cut;
  std::set<std::string> droppedAttributes;  ///< names
};

/// A closed 4D mesh whose points (x, y, z, t) are mapped linearly, with space and time mixed: axes
/// exchanged, or time reversed. Slabs become others, so the mesh is put together, mapped, and cut
/// anew (cutIntoSlabs); it is in memory whole. It stays outward. For maps that keep time apart,
/// model::Transformed takes a slab at a time and keeps attributes.
///
/// Fails when the source does, for a determinant of 0, and as flatten and cutIntoSlabs do.
Result<MappedMesh> mapSpaceTime(const model::Source& source, const Eigen::Matrix4d& map,
                                const model::Progress& progress = {});

}  // namespace t4d::edit
