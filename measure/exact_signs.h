#pragma once

#include "model/exact_sum.h"
#include "t4d/mesh.h"

/// Signs of determinants, exact for all finite coordinates: in double precision with a bound on the
/// rounding (Shewchuk 1997), and where that does not decide, by an ExactSum.
namespace t4d::measure {

using Point2 = Eigen::Vector2d;

/// The sign of det[b - a, c - a]: 1 if a, b, c are counter-clockwise, 0 if they are on one line.
int orientation(const Point2& a, const Point2& b, const Point2& c);

/// The sign of det[b - a, c - a, d - a]: 1 if the triangle a, b, c is clockwise seen from d, 0 if
/// the four points are in one plane.
int orientation(const model::Point3& a, const model::Point3& b, const model::Point3& c,
                const model::Point3& d);

/// `orientation` with d moved by (e, e^2, e^3) for an e smaller than any number: 0 only if a, b and
/// c are on one line. All points of a lattice that are moved so are off all planes, consistently
/// (simulation of simplicity; Edelsbrunner and Muecke 1990).
int movedOrientation(const model::Point3& a, const model::Point3& b, const model::Point3& c,
                     const model::Point3& d);

/// The coordinates of a point across an axis: (y, z), (z, x) or (x, y).
inline Point2 acrossAxis(const model::Point3& p, int axis) {
  return {p[(axis + 1) % 3], p[(axis + 2) % 3]};
}

}  // namespace t4d::measure
