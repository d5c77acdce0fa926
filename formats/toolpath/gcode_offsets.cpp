#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "formats/toolpath/gcode_machine.h"
#include "model/degrees.h"

/// Words of group 0 of a GcodeMachine: origins, shifts of them, and places of the machine.
namespace t4d::formats {
namespace {

std::string systemWord(std::size_t system) {
  return gcodeWord(static_cast<int>(system < 6 ? 540 + 10 * system : 585 + system));
}

}  // namespace

Result<void> GcodeMachine::applyNonModal(Tenths code, const GcodeBlock& block) {
  switch (code) {
    case 40:
      return dwell(block);
    case 100:
      return setOrigin(block);
    case 280:
    case 300:
      return goToReference(code, block);
    case 281:
    case 301:
      if (!(known_[0] && known_[1] && known_[2])) {
        return invalid(fmt::format("{} comes before X, Y and Z have been given", gcodeWord(code)));
      }
      references_[code == 281 ? 0 : 1] = at_;
      return {};
    case 530:
      return moveInMachine(block);
    default:
      return shiftOrigin(code, block);
  }
}

/// P, its seconds, or X or U of Fanuc's controls.
Result<void> GcodeMachine::dwell(const GcodeBlock& block) {
  ++dwells_;
  const bool others = block.axes[1] || block.axes[2] || block.axes[3] || block.axes[4] ||
                      block.axes[5] || block.hasCentre() || block.r;
  if (block.p) dwell_ += *block.p * (habits_.millisecondDwells && block.isWhole('P') ? 1e-3 : 1);
  if (block.p && (others || block.axes[0])) return move(block);
  if (others) {
    return invalid("G4 (a dwell) stands with coordinates or R, and without P, its seconds");
  }
  if (!block.p) dwell_ += block.axes[0].value_or(block.dwell.value_or(0));
  return {};
}

/// The first origin of which nothing is said is that of the stock.
Result<void> GcodeMachine::useOrigin(std::size_t system) {
  if (origins_[system]) return {};
  if (!unstated_) {
    unstated_ = system;
    origins_[system] = MachineAxes{};
    return {};
  }
  return fail(ErrorCode::Unsupported,
              fmt::format("{} is a second origin, after {}; say where it is in the frame of the "
                          "stock",
                          systemWord(system), systemWord(*unstated_)),
              {}, Remedy::Origin);
}

double GcodeMachine::offsetOf(int axis) const {
  const auto i = static_cast<std::size_t>(axis);
  const auto& origin = origins_[modes_.system];
  return (origin ? (*origin)[i] : 0) + shift_[i] + (axis < 3 ? lengthOffset_[axis] : 0);
}

Result<void> GcodeMachine::setOrigin(const GcodeBlock& block) {
  const double kind = block.l.value_or(0);
  if (kind != 2 && kind != 20) {
    return fail(ErrorCode::Unsupported,
                fmt::format("G10 L{:g} is not supported: L2 and L20 set origins; lengths of tools "
                            "are those of a tool table",
                            kind),
                {}, Remedy::ToolTable);
  }
  const double number = block.p.value_or(0);
  if (!(number >= 0 && number <= 9) || number != std::floor(number)) {
    return invalid(fmt::format("G10 P{:g}: origins have the numbers 1 to 9", number));
  }
  if (kind == 2 && !machineZero_ && block.hasAxes()) {
    return fail(ErrorCode::Unsupported,
                "G10 L2 sets an origin from the zero of the machine; say where that is in the "
                "frame of the stock",
                {}, Remedy::MachineZero);
  }
  const std::size_t system = number == 0 ? modes_.system : static_cast<std::size_t>(number) - 1;
  if (block.r) turns_[system] = *block.r;
  const bool all = block.axes[0] && block.axes[1] && block.axes[2];
  if (kind == 20 && !all) {
    if (auto used = useOrigin(system); !used) return used;
  }
  MachineAxes origin = origins_[system].value_or(machineZero_.value_or(MachineAxes{}));
  for (int axis = 0; axis < 6; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    if (!block.axes[i]) continue;
    const double value = *block.axes[i] * unitOf(axis);
    if (kind == 2) {
      origin[i] = (*machineZero_)[i] + value;
    } else if (axis < 3 && !known_[i]) {
      return invalid(fmt::format("G10 L20 comes before {} has been given", "XYZ"[axis]));
    } else {
      origin[i] = at_[i] - shift_[i] - (axis < 3 ? lengthOffset_[axis] : 0) - value;
    }
  }
  if (kind == 20 && turns_[system] != 0) {
    // The tool is at these coordinates where they are turned about the origin.
    MachineAxes values = {};
    for (int axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<std::size_t>(axis);
      values[i] = block.axes[i] ? *block.axes[i] * unitOf(axis) + shift_[i]
                                : at_[i] - offsetOf(axis) + shift_[i];
    }
    const MachineAxes place = turnedAxes(at_);
    const Eigen::Vector2d turned = Eigen::Rotation2Dd(turns_[system] / model::kDegreesPerRadian) *
                                   Eigen::Vector2d(values[0], values[1]);
    for (std::size_t i = 0; i < 2; ++i) {
      const auto axis = static_cast<Eigen::Index>(i);
      origin[i] = place[i] - lengthOffset_[axis] - turned[axis];
    }
  }
  origins_[system] = origin;
  return {};
}

Result<void> GcodeMachine::shiftOrigin(Tenths code, const GcodeBlock& block) {
  if (code == 921 || code == 922) shift_ = {};
  if (code == 921) storedShift_ = {};
  if (code == 923) shift_ = storedShift_;
  if (code != 520 && code != 920) return {};
  if (!block.hasAxes()) return invalid(fmt::format("{} stands without axes", gcodeWord(code)));
  if (auto used = useOrigin(modes_.system); !used) return used;
  for (int axis = 0; axis < 6; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    if (!block.axes[i]) continue;
    const double value = *block.axes[i] * unitOf(axis);
    if (code == 520) {
      shift_[i] = value;
    } else if (axis < 3 && !known_[i]) {
      return invalid(fmt::format("G92 comes before {} has been given", "XYZ"[axis]));
    } else {
      shift_[i] += at_[i] - offsetOf(axis) - value;
    }
  }
  storedShift_ = shift_;
  return {};
}

/// By way of the point that is given, and then, in its axes, to the reference.
Result<void> GcodeMachine::goToReference(Tenths code, const GcodeBlock& block) {
  if (tipControl_) return invalid(gcodeWord(code) + " stands after G43.4; give G49 before");
  ++moves_;
  GcodeBlock by = block;
  for (std::size_t i = 0; i < 3; ++i) {
    // No way from where it is, as in G91 G28 Z0.
    if (modes_.relative && !known_[i] && by.axes[i] == 0.0) by.axes[i].reset();
  }
  if (by.hasAxes()) {
    if (auto used = useOrigin(modes_.system); !used) return used;
    std::array<bool, 3> known = known_;
    const auto to = targetOf(by, at_, known);
    if (!to) return to.error();
    if (auto moved = startOrGo(*to, known, true); !moved) return moved;
  }
  GcodeBlock axes;
  for (std::size_t i = 0; i < 6; ++i) {
    if (block.axes[i] || !block.hasAxes()) axes.axes[i] = 0;
  }
  return goInMachine(axes, references_[code == 280 ? 0 : 1], true);
}

Result<void> GcodeMachine::moveInMachine(const GcodeBlock& block) {
  if (tipControl_) return invalid("G53 stands after G43.4; give G49 before");
  if (modes_.relative) return invalid("G53 is for absolute positions; give G90 before");
  if (!motion_ || *motion_ > 10) return invalid("G53 is for straight moves; give G0 or G1");
  ++moves_;
  if (auto good = checkCut(*motion_ != 0); !good) return good;
  if (!machineZero_ && *motion_ != 0) {
    return fail(ErrorCode::Unsupported,
                "a cutting move to a place of the machine is not supported where that is not known",
                {}, Remedy::MachineZero);
  }
  std::optional<MachineAxes> to = machineZero_;
  for (int axis = 0; axis < 6 && to; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    (*to)[i] += block.axes[i].value_or(0) * unitOf(axis);
  }
  return goInMachine(block, to, *motion_ == 0);
}

/// In the axes of a block. If X, Y or Z of the place are not known, the tool is out of the way from
/// there on; rotary axes have their zero where the program has it.
Result<void> GcodeMachine::goInMachine(const GcodeBlock& axes,
                                       const std::optional<MachineAxes>& place, bool rapid) {
  MachineAxes to = turnedAxes(at_);
  std::array<bool, 3> known = known_;
  bool isLost = false;
  for (std::size_t i = 0; i < 6; ++i) {
    if (!axes.axes[i]) continue;
    to[i] = place ? (*place)[i] : i < 3 ? to[i] : *axes.axes[i];
    if (i < 3) known[i] = place.has_value();
    isLost = isLost || (i < 3 && !place);
  }
  to = unturnedAxes(to);
  if (!isLost) return startOrGo(to, known, rapid);
  if (leftOut_++ == 0) firstLeftOut_ = line_;
  lastLeftOut_ = line_;
  known_ = known;
  if (builder_.started()) builder_.leave();
  at_ = tool_ = to;
  return {};
}

}  // namespace t4d::formats
