#pragma once

#include "t4d/mesh4d/cap.h"

namespace t4d::mesh4d {

/// `fillSolid` by TetGen, for a closed surface without self-intersections whose coordinates are
/// about 1. TetGen runs in a process of its own, with limits on its memory and time.
Result<Cap> tetgenCap(const model::TriangleMesh& mesh);

}  // namespace t4d::mesh4d
