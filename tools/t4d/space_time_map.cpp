#include "tools/t4d/space_time_map.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace t4d::tools {

std::optional<Eigen::Matrix4d> axesMatrix(const std::string& axes) {
  const std::string letters = "xyzt";
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Zero();
  int row = 0;
  double sign = 1;
  for (const char c : axes) {
    if (c == '-' && sign > 0) {
      sign = -1;
      continue;
    }
    const auto column = letters.find(c);
    if (column == std::string::npos || row == 4) return std::nullopt;
    matrix(row++, static_cast<Eigen::Index>(column)) = sign;
    sign = 1;
  }
  if (row == 3) matrix(row++, 3) = 1;
  if (row != 4 || sign < 0 || std::abs(matrix.determinant()) != 1) return std::nullopt;
  return matrix;
}

bool areAxes(const std::string& axes) { return axesMatrix(axes).has_value(); }

bool mixesTime(const TransformOptions& options) {
  return !options.axes.empty() && (*axesMatrix(options.axes))(3, 3) != 1;
}

model::Transform transformOf(const TransformOptions& options) {
  model::Transform transform;
  auto linear = transform.space.leftCols<3>();
  auto shift = transform.space.col(3);
  if (!options.axes.empty() && !mixesTime(options)) {
    linear = axesMatrix(options.axes)->topLeftCorner<3, 3>();
  }
  if (options.scale) {
    const Eigen::Map<const Eigen::Vector3d> factors(options.scale->data());
    linear = (factors.asDiagonal() * linear).eval();
  }
  if (options.rotate) {
    const Eigen::Map<const Eigen::Vector3d> axis(options.rotate->axis.data());
    const Eigen::AngleAxisd turn(options.rotate->degrees * std::numbers::pi / 180,
                                 axis.stableNormalized());
    linear = (turn.toRotationMatrix() * linear).eval();
  }
  if (options.matrix) {
    const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> matrix(
        options.matrix->data());
    linear = (matrix.leftCols<3>() * linear).eval();
    shift = matrix.col(3);
  }
  if (options.move) shift += Eigen::Map<const Eigen::Vector3d>(options.move->data());
  transform.timeScale = options.timeScale;
  transform.timeShift = options.timeShift;
  return transform;
}

}  // namespace t4d::tools
