#pragma once

#include <algorithm>
#include <optional>

#include "t4d/error.h"
#include "t4d/surface.h"

namespace t4d::measure {

/// The distance between two surfaces, in length units.
struct SurfaceDistance {
  /// The largest distance of a point of A from B, and of a point of B from A; both may be too small
  /// by up to `tolerance`.
  double fromA = 0;
  double fromB = 0;
  double tolerance = 0;

  /// The Hausdorff distance.
  double hausdorff() const { return std::max(fromA, fromB); }
};

/// The two one-sided distances of triangle meshes as sets of points, ignoring vertices without a
/// triangle. `relativeTolerance` > 0 is a fraction of the diagonal of the bounds of both.
///
/// Distances of points are exact (TriangleTree). A triangle is halved as long as it may contain a
/// point that is farther than the farthest found so far by more than the tolerance. The bound: the
/// distance from one triangle of the other mesh is convex, so its maximum over a piece is at a
/// corner, and it is not less than the distance from the whole mesh. Identical surfaces give 0.
///
/// Infinite, with tolerance 0, if exactly one mesh is empty; 0 if both are.
SurfaceDistance surfaceDistance(const model::TriangleMesh& a, const model::TriangleMesh& b,
                                double relativeTolerance = 1e-3);

/// An upper bound of the distance of all points of `a` from `b`, too large by no more than a
/// fraction of the diagonal of the bounds of both. Neither may be empty.
double farthestFrom(const model::TriangleMesh& a, const model::TriangleMesh& b,
                    double relativeTolerance = 1e-3);

/// The distance of some point of one surface from the other that is more than `distance`; nothing
/// if there is none, but for points farther by less than a thousandth of it. Much faster than
/// surfaceDistance where the answer is clear: infinite if exactly one mesh is empty.
///
/// Fails if it takes more than some million steps, as for surfaces that lie on one another, in
/// other triangles, and a `distance` that is many times smaller than these.
Result<std::optional<double>> fartherThan(double distance, const model::TriangleMesh& a,
                                          const model::TriangleMesh& b);

}  // namespace t4d::measure
