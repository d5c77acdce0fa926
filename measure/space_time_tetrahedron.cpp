#include "measure/space_time_tetrahedron.h"

#include <algorithm>
#include <limits>

#include "model/cell_normal.h"
#include "model/distance.h"

namespace t4d::measure {
namespace {

using model::Point3;
using model::Point4;

double squaredDistanceToTriangle(const Point3& p, const Point3& a, const Point3& b,
                                 const Point3& c) {
  const Point3 ab = b - a;
  const Point3 ac = c - a;
  const Point3 ap = p - a;
  const Point3 normal = ab.cross(ac);
  const double area = normal.squaredNorm();
  if (area > 0) {
    const double v = normal.dot(ap.cross(ac)) / area;
    const double w = normal.dot(ab.cross(ap)) / area;
    if (v >= 0 && w >= 0 && v + w <= 1) {
      const double height = normal.dot(ap);
      return height * height / area;
    }
  }
  return std::min({model::squaredDistanceToSegment(p, a, b),
                   model::squaredDistanceToSegment(p, b, c),
                   model::squaredDistanceToSegment(p, c, a)});
}

Eigen::Vector4d normalOf(const std::array<Point4, 4>& corners) {
  const Eigen::Vector4d normal = model::cellNormal(corners);
  const double size = normal.head<3>().norm();
  return size > 0 ? Eigen::Vector4d(normal / size) : normal;
}

}  // namespace

SpaceTimeTetrahedron::SpaceTimeTetrahedron(const std::array<Point4, 4>& of)
    : corners(of), bounds(boundsOf(of)), normal(normalOf(of)) {}

double SpaceTimeTetrahedron::squaredDistance(const Point4& point, double limit) const {
  if (point[3] < timeBegin() || point[3] > timeEnd()) {
    return std::numeric_limits<double>::infinity();
  }
  // Neither is more than the distance, and both are found fast.
  const double toBounds =
      (bounds.min - point).cwiseMax(point - bounds.max).cwiseMax(0).squaredNorm();
  if (toBounds > limit) return toBounds;
  const double height = normal.dot(point - corners[0]);
  if (height * height > limit) return height * height;
  return squaredDistanceToSection(point);
}

/// The square of the distance of a point from the section of a tetrahedron at its own time, at
/// which the tetrahedron exists.
double SpaceTimeTetrahedron::squaredDistanceToSection(const Point4& point) const {
  const double time = point[3];
  std::array<Point3, 4> section = {corners[0].head<3>(), corners[0].head<3>(), corners[0].head<3>(),
                                   corners[0].head<3>()};
  int count = 0;
  for (const Point4& corner : corners) {
    if (corner[3] == time) section[count++] = corner.head<3>();
  }
  // Between two corners before the time and two after it, the section has four corners: every
  // other row backwards goes around it.
  bool backwards = false;
  for (const Point4& before : corners) {
    if (!(before[3] < time)) continue;
    for (int k = 0; k < 4; ++k) {
      const Point4& after = corners[backwards ? 3 - k : k];
      if (!(after[3] > time)) continue;
      const double s = (time - before[3]) / (after[3] - before[3]);
      section[count++] = before.head<3>() + s * (after - before).head<3>();
    }
    backwards = !backwards;
  }
  const Point3 p = point.head<3>();
  if (count == 1) return (p - section[0]).squaredNorm();
  if (count == 2) return model::squaredDistanceToSegment(p, section[0], section[1]);
  const double one = squaredDistanceToTriangle(p, section[0], section[1], section[2]);
  if (count == 3) return one;
  return std::min(one, squaredDistanceToTriangle(p, section[0], section[2], section[3]));
}

}  // namespace t4d::measure
