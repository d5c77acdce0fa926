#pragma once

#include <limits>

#include <Eigen/Geometry>

namespace t4d::model {

using Point3 = Eigen::Vector3d;  ///< x, y, z in length units
using Point4 = Eigen::Vector4d;  ///< x, y, z in length units, t in time units

/// Axis-aligned bounds; empty (min > max) until something is added.
template <int Dimension>
struct Bounds {
  using Point = Eigen::Matrix<double, Dimension, 1>;
  Point min = Point::Constant(std::numeric_limits<double>::infinity());
  Point max = Point::Constant(-std::numeric_limits<double>::infinity());

  bool empty() const { return !(min.array() <= max.array()).all(); }
  void add(const Point& point) {
    min = min.cwiseMin(point);
    max = max.cwiseMax(point);
  }
  /// Empty bounds add nothing.
  void add(const Bounds& other) {
    min = min.cwiseMin(other.min);
    max = max.cwiseMax(other.max);
  }
};

using Bounds3 = Bounds<3>;
using Bounds4 = Bounds<4>;

}  // namespace t4d::model
