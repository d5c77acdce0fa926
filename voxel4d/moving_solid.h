#pragma once

#include <functional>

#include "model/motion.h"
#include "model/triangle_mesh.h"

namespace t4d::voxel4d {

/// A solid as a function of time: closed and facing outward; empty if there is none.
using SolidAtTime = std::function<Result<model::TriangleMesh>(double time)>;

/// `mesh` in the poses of `motion`.
SolidAtTime movingSolid(model::TriangleMesh mesh, model::Motion motion);

}  // namespace t4d::voxel4d
