#pragma once

#include <algorithm>

#include "t4d/mesh.h"

namespace t4d::model {

/// The squared distance from p to the segment from a to b, which may be a single point.
inline double squaredDistanceToSegment(const Point3& p, const Point3& a, const Point3& b) {
  const Point3 along = b - a;
  const double length2 = along.squaredNorm();
  const double s = length2 > 0 ? std::clamp(along.dot(p - a) / length2, 0.0, 1.0) : 0;
  return (a + s * along - p).squaredNorm();
}

}  // namespace t4d::model
