#include "formats/toolpath/rotary_kinematics.h"

#include <algorithm>
#include <cmath>
#include <ranges>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "formats/toolpath/tool_path.h"
#include "model/degrees.h"

namespace t4d::formats {
namespace {

// A turn of more would have a chord that says little of it.
constexpr double kMostDegrees = 10;

}  // namespace

Result<RotaryAxis> parseRotaryAxis(std::string_view text) {
  const std::string_view whole = text;
  const auto wrong = [&] {
    return invalid(
        fmt::format("'{}' is not a rotary axis; expected a letter, table or head, and a point of "
                    "the axis, as in "
                    "A=table:0,0,-50",
                    whole));
  };
  RotaryAxis axis;
  if (text.size() < 2 || text[0] < 'A' || text[0] > 'C' || text[1] != '=') return wrong();
  axis.axis = 3 + text[0] - 'A';
  text.remove_prefix(2);
  if (text.starts_with('-')) {
    axis.direction = -1;
    text.remove_prefix(1);
  }
  const std::string_view side = text.substr(0, text.find(':'));
  if (side != "table" && side != "head") return wrong();
  axis.onTable = side == "table";
  text.remove_prefix(side.size());
  if (text.empty()) return axis;
  const auto point = parsePoint(text.substr(1));
  if (!point) return wrong();
  axis.point = *point;
  return axis;
}

bool RotaryKinematics::turns(int axis) const {
  return std::ranges::find(axes_, axis, &RotaryAxis::axis) != axes_.end();
}

Eigen::Matrix3d RotaryKinematics::rotationOf(const RotaryAxis& axis, const MachineAxes& at) const {
  const double degrees = axis.direction * at[static_cast<std::size_t>(axis.axis)];
  return Eigen::AngleAxisd(std::remainder(degrees, 360.0) * model::kRadiansPerDegree,
                           Eigen::Vector3d::Unit(axis.axis - 3))
      .toRotationMatrix();
}

ToolPlace RotaryKinematics::toolAt(const MachineAxes& at, const Eigen::Vector3d& length) const {
  ToolPlace place{-length, Eigen::Vector3d::UnitZ()};
  for (const RotaryAxis& axis : axes_ | std::views::reverse) {
    if (axis.onTable) continue;
    const Eigen::Matrix3d rotation = rotationOf(axis, at);
    place.tip = axis.point + rotation * (place.tip - axis.point);
    place.axis = rotation * place.axis;
  }
  place.tip += Eigen::Vector3d(at[0], at[1], at[2]);
  for (const RotaryAxis& axis : axes_) {
    if (!axis.onTable) continue;
    const Eigen::Matrix3d rotation = rotationOf(axis, at);
    place.tip = axis.point + rotation * (place.tip - axis.point);
    place.axis = rotation * place.axis;
  }
  return place;
}

MachineAxes RotaryKinematics::positionOf(const model::Point3& tip, const MachineAxes& angles,
                                         const Eigen::Vector3d& length) const {
  MachineAxes at = angles;
  std::fill_n(at.begin(), 3, 0.0);
  // The tip of the position zero, before the table turns.
  RotaryKinematics head(axes_);
  std::erase_if(head.axes_, [](const RotaryAxis& axis) { return axis.onTable; });
  Eigen::Vector3d place = tip;
  for (const RotaryAxis& axis : axes_ | std::views::reverse) {
    if (axis.onTable) {
      place = axis.point + rotationOf(axis, at).transpose() * (place - axis.point);
    }
  }
  place -= head.toolAt(at, length).tip;
  std::copy_n(place.data(), 3, at.begin());
  return at;
}

double RotaryKinematics::partsOf(const MachineAxes& from, const MachineAxes& to,
                                 const Eigen::Vector3d& length, double reach,
                                 double tolerance) const {
  double degrees = 0;
  double radius = reach + length.norm();
  Eigen::Vector3d way;
  Eigen::Vector3d farthest;
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    way[i] = to[axis] - from[axis];
    farthest[i] = std::max(std::abs(from[axis]), std::abs(to[axis]));
  }
  for (const RotaryAxis& axis : axes_) {
    const auto i = static_cast<std::size_t>(axis.axis);
    degrees += std::abs(to[i] - from[i]);
    radius += 2 * axis.point.norm();
  }
  if (degrees == 0) return 1;
  // A chord is off by an eighth of the second derivative: of R(t) p(t) with the angular speed w it
  // is at most w^2 |p| + 2 w |p'|.
  const double turn = degrees * model::kRadiansPerDegree;
  const double bend = turn * turn * (radius + farthest.norm()) + 2 * turn * way.norm();
  return std::ceil(std::max(std::sqrt(bend / (8 * tolerance)), degrees / kMostDegrees));
}

}  // namespace t4d::formats
