#pragma once

#include "t4d/mesh4d/cap.h"

namespace t4d::mesh4d {

/// `fillSolid` by TetGen, for a closed surface whose coordinates are about 1, after
/// checkNoSelfIntersection. Both run in a process of their own, with limits on memory and time in
/// proportion to the mesh.
Result<Cap> tetgenCap(const model::TriangleMesh& mesh);

}  // namespace t4d::mesh4d
