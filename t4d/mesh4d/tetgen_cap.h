#pragma once

#include "t4d/mesh4d/cap.h"

namespace t4d::mesh4d {

/// `fillSolid` by TetGen, for a surface that is known to be closed and free of intersections.
/// TetGen is not thread-safe, so calls wait for each other.
Result<Cap> tetgenCap(const model::TriangleMesh& mesh);

}  // namespace t4d::mesh4d
