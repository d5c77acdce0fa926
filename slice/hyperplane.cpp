#include <cmath>

#include <Eigen/LU>
#include <fmt/format.h>

#include "t4d/slice.h"

namespace t4d::slice {

HyperplaneBasis basisOf(const Hyperplane& hyperplane) {
  const Eigen::Vector4d normal = scaledHyperplane(hyperplane).normal.normalized();
  int leftOut = 3;
  for (int axis = 2; axis >= 0; --axis) {
    if (std::abs(normal[axis]) > std::abs(normal[leftOut])) leftOut = axis;
  }
  HyperplaneBasis basis;
  int row = 0;
  for (int axis = 0; axis < 4; ++axis) {
    if (axis == leftOut) continue;
    Eigen::Vector4d direction = Eigen::Vector4d::Unit(axis);
    direction -= normal.dot(direction) * normal;
    for (int before = 0; before < row; ++before) {
      direction -= basis.axes.row(before).dot(direction) * basis.axes.row(before).transpose();
    }
    basis.axes.row(row++) = direction.normalized().transpose();
  }
  Eigen::Matrix4d frame;
  frame.leftCols<3>() = basis.axes.transpose();
  frame.col(3) = normal;
  basis.rightHanded = frame.determinant() > 0;
  return basis;
}

Result<void> checkHyperplane(const Hyperplane& hyperplane) {
  const Eigen::Vector4d& n = hyperplane.normal;
  const double largest = n.cwiseAbs().maxCoeff();
  if (!n.allFinite() || !(largest > 0) ||
      !std::isfinite(std::scalbn(hyperplane.offset, -std::ilogb(largest)))) {
    return invalid(
        fmt::format("the hyperplane has the normal ({}, {}, {}, {}) and the offset {}; the numbers "
                    "must be finite, the normal not zero, and their ratio finite",
                    n[0], n[1], n[2], n[3], hyperplane.offset));
  }
  return {};
}

Hyperplane scaledHyperplane(const Hyperplane& hyperplane) {
  if (!checkHyperplane(hyperplane)) return hyperplane;
  const int exponent = -std::ilogb(hyperplane.normal.cwiseAbs().maxCoeff());
  const auto scaled = [&](double number) { return std::scalbn(number, exponent); };
  return {hyperplane.normal.unaryExpr(scaled), scaled(hyperplane.offset)};
}

}  // namespace t4d::slice
