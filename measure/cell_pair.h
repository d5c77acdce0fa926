#pragma once

#include <array>
#include <optional>

#include "t4d/mesh.h"

/// Two tetrahedra in space-time: whether they meet, and when.
namespace t4d::measure {

/// The corners of a cell; it may be flat.
using CellCorners = std::array<model::Point4, 4>;

/// The common points of two cells: a convex polytope.
struct CellMeeting {
  double timeBegin = 0;                         ///< least t of a common point
  double timeEnd = 0;                           ///< greatest t of a common point
  model::Point3 point = model::Point3::Zero();  ///< where, at timeBegin
  /// Neither cell is flat, and they cross: interior points of the two meet in a plane, not in a
  /// common hyperplane. Then the interiors of the solids that they bound meet, too.
  bool crosses = false;
  /// Interior points of the two meet in a common hyperplane, and outside is on the same side of it
  /// for both. Then, too, the interiors of the solids meet.
  bool coincides = false;
};

/// What the closed cells have in common; nothing if they do not meet. Whether they meet, and
/// whether they cross, is decided exactly for the coordinates as they are, which must be finite.
/// Times and point are computed in double precision.
///
/// A corner of what two polytopes have in common is the only common point of a face of the one and
/// a face of the other. For cells in general position these are an edge and a cell, or two
/// triangles: six of the eight corners, with one affine dependency, whose coefficients are
/// determinants of five points each. (Shewchuk's filter: determinants are computed in double
/// precision with a bound of the error; if a sign matters that this does not decide, all are
/// computed again with integers.)
///
/// Where only crossings matter, cells of a common hyperplane are passed over: they cannot cross,
/// and take long.
std::optional<CellMeeting> meetingOf(const CellCorners& a, const CellCorners& b,
                                     bool crossingsOnly = false);

/// Like meetingOf, but times are exact and rounded once. It is slower by one or two orders of
/// magnitude.
std::optional<CellMeeting> meetingRoundedOnce(const CellCorners& a, const CellCorners& b);

}  // namespace t4d::measure
