#pragma once

#include "measure/visit_lattice.h"

namespace t4d::measure {

/// A surface about a set of places, with a distance that it keeps for certain.
struct OffsetSurface {
  model::TriangleMesh mesh;  ///< closed, oriented, manifold
  /// No point within the surface is farther from the set than this, in length units.
  double farthest = 0;
};

/// The surface about all places that are no farther than `reach` from the places with a winding
/// number of 1 or more and from `surface` itself, both of which `visits` was made of. Its lattice
/// must enclose them by `offsetMargin`.
///
/// Let d(p) be the distance of p from the set S, and h the spacing of the lattice. The cubes are
/// cut into six tetrahedra each, d^2 is taken linear in each of them between its corners, and the
/// surface is where this function F has the value
///
///   level^2 = reach^2 + 3/4 h^2.
///
/// It contains all p with d(p) <= reach: d^2 - |p|^2 is the least of functions that are linear in
/// p, one for each point of S, and so concave. Hence for p = sum w_i v_i,
///   F(p) = sum w_i d^2(v_i) <= d^2(p) - |p|^2 + sum w_i |v_i|^2 = d^2(p) + sum w_i |v_i - p|^2,
/// and the last sum, a variance, is at most the square of the radius of a ball about the
/// corners: 3/4 h^2. It contains no p with d(p) > level + sqrt(3)/2 h: distances differ by no more
/// than places, so F(p) >= (sum w_i d(v_i))^2 >= (d(p) - sum w_i |v_i - p|)^2.
///
/// Vertices keep kOffsetMargin of an edge away from lattice points, and reach is enlarged by as
/// much. The rounding of coordinates is left to the caller, to be added to `reach`.
/// Fails if it is told to stop.
Result<OffsetSurface> offsetSurface(const model::TriangleMesh& surface, const VisitLattice& visits,
                                    double reach, const model::Progress& progress = {});

inline constexpr double kOffsetMargin = 0x1p-6;

/// The distance by which the lattice has to enclose the set.
double offsetMargin(double reach, double spacing);

/// The value of OffsetSurface::farthest.
double farthestOfOffset(double reach, double spacing);

}  // namespace t4d::measure
