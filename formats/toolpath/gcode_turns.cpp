#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "formats/toolpath/gcode_machine.h"
#include "model/degrees.h"

/// What turns, scales and mirrors the program of a GcodeMachine: G10 L2 R, G68, G51, G51.1.
namespace t4d::formats {

MachineAxes GcodeMachine::turnedAxes(const MachineAxes& at) const {
  if (!turned_) return at;
  MachineAxes turned = at;
  const Eigen::Vector3d point = *turned_ * Eigen::Vector3d(at[0], at[1], at[2]);
  std::copy_n(point.data(), 3, turned.begin());
  return turned;
}

MachineAxes GcodeMachine::unturnedAxes(const MachineAxes& at) const {
  if (!turned_) return at;
  MachineAxes program = at;
  const Eigen::Vector3d point = turned_->inverse() * Eigen::Vector3d(at[0], at[1], at[2]);
  std::copy_n(point.data(), 3, program.begin());
  return program;
}

/// The point of X, Y and Z in the program, where what is not given is where the tool is.
model::Point3 GcodeMachine::pointOf(const GcodeBlock& block) const {
  model::Point3 point;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    point[axis] = block.axes[i] ? *block.axes[i] * modes_.unit : at_[i] - offsetOf(axis);
  }
  return point;
}

Result<void> GcodeMachine::setTurns(const GcodeBlock& block) {
  if (compensation_) {
    return invalid("the program is turned where the cutter is compensated; give G40 before");
  }
  const auto rotation = block.code(GcodeGroup::Rotation);
  const auto scale = block.code(GcodeGroup::Scale);
  const auto mirror = block.code(GcodeGroup::Mirror);
  if (rotation == 690) turn_.reset();
  if (rotation == 680) {
    if (!block.r) return invalid("G68 has no R, the angle");
    turn_ = Turn{.plane = modes_.plane, .about = pointOf(block), .degrees = *block.r};
  }
  if (scale == 500) scale_.reset();
  if (scale == 510) {
    if (auto set = setScale(block); !set) return set;
  }
  if (mirror == 511) {
    if (!block.hasAxes()) return invalid("G51.1 stands without X, Y or Z, where it mirrors");
    if (!mirror_) mirror_ = Scale{};
    for (int axis = 0; axis < 3; ++axis) {
      const auto& given = block.axes[static_cast<std::size_t>(axis)];
      if (!given) continue;
      mirror_->about[axis] = *given * modes_.unit;
      mirror_->factors[axis] = -1;
    }
  }
  if (mirror == 501 && mirror_) {
    for (int axis = 0; axis < 3; ++axis) {
      if (block.axes[static_cast<std::size_t>(axis)] || !block.hasAxes())
        mirror_->factors[axis] = 1;
    }
    if (mirror_->factors == Eigen::Vector3d::Ones()) mirror_.reset();
  }
  turnAgain();
  return {};
}

/// P or I, J and K are factors, about X, Y and Z; without them X, Y and Z are, on Mach3.
Result<void> GcodeMachine::setScale(const GcodeBlock& block) {
  Scale scale;
  const auto factorOf = [&](char letter, double value) {
    return block.isWhole(letter) ? value / 1000 : value;
  };
  if (block.p) {
    scale.factors.setConstant(factorOf('P', *block.p));
  } else if (block.hasCentre()) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (block.centre[i]) {
        scale.factors[static_cast<Eigen::Index>(i)] = factorOf("IJK"[i], *block.centre[i]);
      }
    }
  } else if (habits_.dialect == GcodeDialect::Mach3) {
    for (std::size_t i = 0; i < 3; ++i) {
      scale.factors[static_cast<Eigen::Index>(i)] = block.axes[i].value_or(1);
    }
  } else {
    return invalid(
        "G51 has no P, and no I, J and K, the factors; X, Y and Z are factors with --dialect "
        "mach3");
  }
  if (habits_.dialect != GcodeDialect::Mach3) scale.about = pointOf(block);
  if ((scale.factors.array() == 0).any()) return invalid("G51 has a factor of 0");
  scale_ = scale;
  return {};
}

/// After anything has changed that turns the program, or the origin that it turns about. The tool
/// stays where it is.
void GcodeMachine::turnAgain() {
  if (!turned_ && !turn_ && !scale_ && !mirror_ && turns_[modes_.system] == 0) return;
  const MachineAxes place = turnedAxes(at_);
  const model::Point3 offset(offsetOf(0), offsetOf(1), offsetOf(2));
  const auto about = [](const model::Point3& point, const auto& linear) {
    return Eigen::Affine3d(Eigen::Translation3d(point) * linear * Eigen::Translation3d(-point));
  };
  const auto rotation = [](int axis, double degrees) {
    return Eigen::AngleAxisd(degrees / model::kDegreesPerRadian, Eigen::Vector3d::Unit(axis));
  };
  const model::Point3 shift(shift_[0], shift_[1], shift_[2]);
  Eigen::Affine3d turned = about(offset - shift, rotation(2, turns_[modes_.system]));
  if (turn_)
    turned = turned * about(turn_->about + offset, rotation(turn_->plane[2], turn_->degrees));
  for (const auto& scale : {scale_, mirror_}) {
    if (scale) turned = turned * about(scale->about + offset, Eigen::Scaling(scale->factors));
  }
  const bool isNone = !turn_ && !scale_ && !mirror_ && turns_[modes_.system] == 0;
  turned_ = isNone ? std::nullopt : std::optional(turned);
  at_ = tool_ = unturnedAxes(place);
}

}  // namespace t4d::formats
