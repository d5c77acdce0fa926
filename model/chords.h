#pragma once

#include <span>

#include "t4d/mesh.h"
#include "t4d/surface.h"

namespace t4d::model {

/// The factor k of Chords, for prisms of 14 cells and of 3 cells.
inline constexpr double kEdgeFactorOf14 = 1.0 / 6;
inline constexpr double kEdgeFactorOf3 = 1.0 / 2;

/// How far a step of a swept mesh can be from the screw motion that it approximates.
///
/// In a step of angle theta, at most a whole turn, let r be the largest distance of a vertex from
/// the axis, and e the length of the edge that is longest across it, the part along it left out.
/// The Hausdorff distance between the surfaces of the mesh and of the true solid, at the same time,
/// is at most
///
///   r (1 - cos(theta/2)) + k e sin(theta/2)
///
/// with k = 1/6 for prisms of 14 cells and 1/2 for prisms of 3. A step that only translates has the
/// bound 0.
///
/// Proof. (1) Along the axis, mesh and motion agree. Across it, with the vertex at r in the complex
/// plane, h = theta/2 and x = 2s - 1 at fraction s of the step, both turned by -h: the motion is at
/// r e^(ixh), the chord at r (cos h + i x sin h). The square of the difference, divided by r^2, is
///   f(x) = 1 + cos^2 h + x^2 sin^2 h - 2 cos h cos xh - 2 x sin h sin xh.
/// It is even, f(0) = (1 - cos h)^2, and for 0 <= x <= 1 it does not grow:
///   f'(x) / 2 = -sin h (sin xh - x sin h) + sin h g(xh) - sin xh g(h),  g(u) = sin u - u cos u.
/// The first term is not positive, since the sine is concave up to h <= pi; nor are the two others
/// together, since g(u) / sin u = 1 - u cot u does not fall. So the difference is at most r (1 -
/// cos h), half way. (2) Points of a triangle that moves with its vertices on chords keep their
/// weights, so they are as near to those of the true triangle. (3) The mesh has other corners
/// between layers. With P, Q the positions of the vertices at the ends of the step, and L between
/// them, a cut point on an edge differs from a point of the triangle of the L (slice/light_slice.h
/// has the weights) by
///   s (1/2 - s) D(ij), or (2s/3) (1/2 - s) (D(ij) + D(ik)), for s <= 1/2, and mirrored above it,
/// where D(ij) = (Q(j) - Q(i)) - (P(j) - P(i)) is an edge's change: 2 sin h times the edge's
/// length across the axis.
/// The largest is e sin h / 6, at s = 1/4. With prisms of 3 cells the cut point on the diagonal
/// from P(i) to Q(j) differs by s (1 - s) D(ij), at most e sin h / 2. The points named divide the
/// triangle as the mesh does, so every point of the section is moved by no more.
struct Chords {
  double radius = 0;                    ///< r, in length units
  double edge = 0;                      ///< e, in length units
  double edgeFactor = kEdgeFactorOf14;  ///< k

  /// The bound for a step that turns by this angle, in length units. Beyond a whole turn, where a
  /// step and its motion have nothing in common, 2 r + k e.
  double forAngle(double radians) const;

  /// The largest angle, in radians and at most half a turn, whose bound is at most `length`, up to
  /// rounding.
  double angleFor(double length) const;
};

/// What the section between two layers adds to the distance of vertices from their true positions:
/// k / 2 times the largest change D(ij) of an edge, by (3) of the proof above. It holds for any
/// motion of the vertices from `from` to `to`.
double edgeDeviation(std::span<const Point3> from, std::span<const Point3> to,
                     std::span<const Triangle> triangles, double edgeFactor);

}  // namespace t4d::model
