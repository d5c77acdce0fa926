#pragma once

#include "t4d/slice.h"

namespace t4d::tools {

/// The mean thickness of a solid's walls: the length of the normal inside the solid, from a point
/// of the surface inward to the next one, as the mean over the area. R - r of a ball of radius R
/// with a hollow of radius r, 2 R without it, the height of a plate that is large. `mesh` must be
/// closed; 0 if it is empty.
double wallThickness(const model::TriangleMesh& mesh);

/// The part of the surface, from 0 to 1, of which the wall behind it is thinner than this.
double thinWalls(const model::TriangleMesh& mesh, double thickness);

/// The mean over the area of how fast the surface moves along its normal, inward or outward, in
/// length units per time unit. The slice must have its motion. 0 if it is empty.
double meanNormalSpeed(const slice::Slice& slice);

}  // namespace t4d::tools
