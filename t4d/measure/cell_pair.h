#pragma once

#include <array>
#include <optional>

#include "t4d/model/geometry.h"

/// Two tetrahedra in space-time: whether they meet, when, and how near they come at equal times.
namespace t4d::measure {

/// The corners of a cell; it may be flat.
using CellCorners = std::array<model::Point4, 4>;

/// What two cells have in common: a convex polytope.
struct CellMeeting {
  double timeBegin = 0;                         ///< least t of a common point
  double timeEnd = 0;                           ///< greatest t of a common point
  model::Point3 point = model::Point3::Zero();  ///< where, at timeBegin
  /// Neither cell is flat, and they cross: interior points of the two meet in a plane, not in a
  /// common hyperplane. Then the interiors of the solids that they bound meet, too.
  bool crosses = false;
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

/// The same with times that are the exact ones, rounded once. Slower by an order of magnitude or
/// two.
std::optional<CellMeeting> meetingRoundedOnce(const CellCorners& a, const CellCorners& b);

/// The smallest distance of two cells at equal times.
struct CellDistance {
  double distance = 0;    ///< between pointA and pointB
  double lowerBound = 0;  ///< no two points of the cells at equal times are nearer
  double time = 0;
  model::Point3 pointA = model::Point3::Zero();
  model::Point3 pointB = model::Point3::Zero();
};

/// Nothing if no time is common to both cells. The differences of points of the cells at equal
/// times are a convex polytope in space: the section of the difference of the cells by t = 0. Its
/// point nearest to the origin is found by the algorithm of Gilbert, Johnson and Keerthi (1988),
/// and the plane through that point, perpendicular to its direction, proves the bound. The distance
/// of two cells that meet may come out as rounding errors.
std::optional<CellDistance> distanceOf(const CellCorners& a, const CellCorners& b);

}  // namespace t4d::measure
