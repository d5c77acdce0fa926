#pragma once

#include "mesh4d/cap.h"

namespace t4d::mesh4d {

/// Calls checkNoSelfIntersection, then fills the solid with TetGen, for a closed surface with
/// coordinates of about 1. Both run in a separate process, with limits on memory and time
/// proportional to the size of the mesh.
Result<Cap> tetgenCap(const model::TriangleMesh& mesh);

}  // namespace t4d::mesh4d
