#pragma once

#include "t4d/mesh4d/cap.h"

namespace t4d::mesh4d {

/// `fillSolid` by TetGen, for a closed surface without self-intersections. TetGen is not
/// thread-safe, so calls are serialized.
Result<Cap> tetgenCap(const model::TriangleMesh& mesh);

}  // namespace t4d::mesh4d
