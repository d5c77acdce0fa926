#pragma once

#include <array>

#include "t4d/mesh.h"

namespace t4d::measure {

/// Whether they are all at one time: such a cell is in no slice.
inline bool isAtOneTime(const std::array<model::Point4, 4>& corners) {
  const double time = corners[0][3];
  return corners[1][3] == time && corners[2][3] == time && corners[3][3] == time;
}

inline model::Bounds4 boundsOf(const std::array<model::Point4, 4>& corners) {
  model::Bounds4 bounds;
  for (const model::Point4& corner : corners) bounds.add(corner);
  return bounds;
}

/// A tetrahedron in space-time, and the hyperplane that it lies in.
struct SpaceTimeTetrahedron {
  std::array<model::Point4, 4> corners;
  model::Bounds4 bounds;
  Eigen::Vector4d normal;  ///< outward; its part in space has length 1, or is 0

  explicit SpaceTimeTetrahedron(const std::array<model::Point4, 4>& corners);

  double timeBegin() const { return bounds.min[3]; }
  double timeEnd() const { return bounds.max[3]; }

  /// The square of the distance of a point from the section of the tetrahedron at the time of the
  /// point; infinite where there is none. Where it is above `limit`, it may be anything above that.
  double squaredDistance(const model::Point4& point, double limit) const;

 private:
  double squaredDistanceToSection(const model::Point4& point) const;
};

}  // namespace t4d::measure
