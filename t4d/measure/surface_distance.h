#pragma once

#include <algorithm>

#include "t4d/model/triangle_mesh.h"

namespace t4d::measure {

/// How far two surfaces are apart, in length units.
struct SurfaceDistance {
  double fromA = 0;      ///< the largest distance of a point of A from B, at most `tolerance` short
  double fromB = 0;      ///< the largest distance of a point of B from A, likewise
  double tolerance = 0;  ///< the true values are from `fromA` to `fromA + tolerance`, and so on

  /// The Hausdorff distance.
  double hausdorff() const { return std::max(fromA, fromB); }
};

/// The two one-sided distances of triangle meshes as sets of points, vertices without a triangle
/// left out. `relativeTolerance` > 0 is a fraction of the diagonal of the bounds of both.
///
/// Distances of points are exact (TriangleTree). Triangles are halved as long as they may hold a
/// point farther than the farthest one found yet by more than the tolerance: the distance from one
/// triangle of the other mesh is convex, so that over a piece it is largest in a corner, and it is
/// not less than the distance from the whole mesh. Identical surfaces give 0.
///
/// Infinite, and without tolerance, where one mesh is empty and the other is not; 0 where both are.
SurfaceDistance surfaceDistance(const model::TriangleMesh& a, const model::TriangleMesh& b,
                                double relativeTolerance = 1e-3);

}  // namespace t4d::measure
