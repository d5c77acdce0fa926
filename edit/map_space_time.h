#pragma once

#include <set>
#include <string>

#include <Eigen/Core>

#include "t4d/edit.h"
#include "t4d/mesh.h"

namespace t4d::edit {

struct MappedMesh {
  CutMesh cut;
  std::set<std::string> droppedAttributes;  ///< names
};

/// Maps the points (x, y, z, t) of a closed 4D mesh linearly, with space and time mixed: axes
/// exchanged, or time reversed. Since slabs do not remain slabs, the whole mesh is collected in
/// memory, mapped, and cut again (cutIntoSlabs). It still faces outward. For maps that do not mix
/// space and time, model::Transformed takes a slab at a time and keeps attributes.
///
/// Fails for a determinant of 0, and if the source, flatten or cutIntoSlabs fails.
Result<MappedMesh> mapSpaceTime(const model::Source& source, const Eigen::Matrix4d& map,
                                const model::Progress& progress = {});

}  // namespace t4d::edit
