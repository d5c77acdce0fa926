#pragma once

#include <cstdint>

#include "t4d/error.h"
#include "t4d/surface.h"

namespace t4d::measure {

struct SolidDifferenceOptions {
  /// Lines along the longer side of each lattice; at least 4.
  std::uint32_t resolution = 256;
};

struct SolidDifference {
  double volume = 0;  ///< of what is asked for, in cubic length units
  double error = 0;   ///< estimate of its error
};

/// The volume of the points that lie in one solid and not in the other, for solids bounded by
/// closed triangle meshes: the integral of |w_a - w_b|, where w is the winding number of a surface
/// about a point. For surfaces that do not intersect themselves w is 1 inside and 0 outside. If
/// they do, parts count as often as they do in signedVolume, so that |V_a - V_b| <= volume always
/// holds, and no part makes the function fail.
///
/// The result is the mean of integrals along four square lattices of parallel lines, exact on each
/// line and by the midpoint rule across, each lattice spanning the bounds of both; parts whose
/// bounds are apart get lattices of their own. The lines are askew to the axes, since solids often
/// have faces along those: then the integrand is continuous, and the error falls with the square of
/// the spacing. `error` is twice the largest deviation of the four from their mean: an estimate,
/// which is too small for about one pair of solids in fifty. Surfaces that consist of the same
/// triangles, in any order, give exactly 0.
///
/// Fails for a mesh that is not closed.
Result<SolidDifference> solidDifference(const model::TriangleMesh& a, const model::TriangleMesh& b,
                                        const SolidDifferenceOptions& options = {});

/// The volume of the points that lie in both solids: the integral of min(w_a, w_b) where that is
/// positive, in the same way, but the lattices span what the solids have in common
/// (common_parts.h): the error is a fraction of the volume, however small it is. Solids whose
/// interiors have no common point give 0 up to rounding.
Result<SolidDifference> solidOverlap(const model::TriangleMesh& a, const model::TriangleMesh& b,
                                     const SolidDifferenceOptions& options = {});

}  // namespace t4d::measure
