#pragma once

#include <Eigen/Geometry>

#include "model/error.h"
#include "model/geometry.h"

namespace t4d::slice {

/// All points p of space-time with normal . p = offset. The normal points to the side called
/// "above".
struct Hyperplane {
  Eigen::Vector4d normal = Eigen::Vector4d::UnitW();
  double offset = 0;

  static Hyperplane atTime(double time) { return {Eigen::Vector4d::UnitW(), time}; }
  /// The hyperplane where the coordinate of an axis (0 to 3 for x, y, z, t) is `value`.
  static Hyperplane across(int axis, double value) { return {Eigen::Vector4d::Unit(axis), value}; }
};

/// normal . point, summed in the order x, y, z, t without fused operations, as SPEC.md, section
/// "Slicing", prescribes, so that all programs agree on which points are on a hyperplane.
inline double along(const Eigen::Vector4d& normal, const model::Point4& point) {
  return normal[0] * point[0] + normal[1] * point[1] + normal[2] * point[2] + normal[3] * point[3];
}

/// Orthonormal coordinates within a hyperplane: multiply the rows by a point of space-time.
///
/// The axis along which the normal is largest is left out (the last one if several are equal). The
/// other three, in the order x, y, z, t, are made orthonormal to the normal and to each other
/// (Gram-Schmidt). For x = c the result is (y, z, t), for t = c it is (x, y, z).
struct HyperplaneBasis {
  Eigen::Matrix<double, 3, 4> axes;
  /// Whether (axis 1, axis 2, axis 3, normal) is oriented like (x, y, z, t).
  bool rightHanded;
};

/// The hyperplane must satisfy checkHyperplane. The opposite normal gives the same axes.
HyperplaneBasis basisOf(const Hyperplane& hyperplane);

/// Fails if a number is not finite, the normal is zero, or the hyperplane is at infinity because
/// the offset is too large for the normal.
Result<void> checkHyperplane(const Hyperplane& hyperplane);

/// An equal hyperplane whose normal has its largest coordinate in [1, 2). Normal and offset are
/// multiplied by a power of two, which is exact. Unchanged if checkHyperplane refuses it.
Hyperplane scaledHyperplane(const Hyperplane& hyperplane);

}  // namespace t4d::slice
