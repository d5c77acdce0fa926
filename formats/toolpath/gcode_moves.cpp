#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "formats/toolpath/gcode_arc.h"
#include "formats/toolpath/gcode_cycles.h"
#include "formats/toolpath/gcode_machine.h"

/// Moves of a GcodeMachine: straight, along arcs and in canned cycles.
namespace t4d::formats {
namespace {

double lengthOf(const MachineAxes& from, const MachineAxes& to, std::size_t first) {
  double square = 0;
  for (std::size_t i = first; i < first + 3; ++i) {
    square += (to[i] - from[i]) * (to[i] - from[i]);
  }
  return std::sqrt(square);
}

bool hasRotary(const GcodeBlock& block) { return block.axes[3] || block.axes[4] || block.axes[5]; }

}  // namespace

Result<MachineAxes> GcodeMachine::targetOf(const GcodeBlock& block,
                                           std::array<bool, 3>& known) const {
  MachineAxes to = at_;
  for (int axis = 0; axis < 6; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    if (!block.axes[i]) continue;
    if (relative_ && axis < 3 && !known_[i]) {
      return invalid(
          fmt::format("{} is relative (G91) where it is not known{}", "XYZ"[axis], sinceLeftOut()));
    }
    to[i] = *block.axes[i] * unitOf(axis) + (relative_ ? at_[i] : offsetOf(axis));
    if (axis < 3) known[i] = true;
  }
  return to;
}

Result<void> GcodeMachine::checkCut(bool cuts) const {
  if (!cuts) return {};
  if (!builder_.started()) {
    return invalid(
        "a cutting move comes before X, Y and Z have been given; begin with G0 and all three");
  }
  if (builder_.isAway()) {
    return invalid(fmt::format("a cutting move where {} is not known{}; give it by G0 before, or "
                               "say where the machine's zero is",
                               unknownAxes(), sinceLeftOut()),
                   {}, Remedy::MachineZero);
  }
  if (inverseTime_ && !(inverseFeed_ > 0)) {
    return invalid("a cutting move with inverse time (G93) has no F in its line");
  }
  if (!inverseTime_ && !(feed_ > 0)) return invalid("a cutting move has no feed; give F before");
  if (options_.tools && mounted_.value_or(0) == 0) {
    return invalid("a cutting move comes before a tool is mounted (T1 M6)", {}, Remedy::AnyTool);
  }
  return {};
}

Result<void> GcodeMachine::move(const GcodeBlock& block) {
  if (!motion_) return invalid("coordinates without G0, G1, G2 or G3 before them");
  const int motion = *motion_;
  if (auto good = checkCut(motion != 0); !good) return good;
  if ((motion == 0 || motion == 10) && (block.hasCentre() || block.r)) {
    return invalid("I, J, K and R are for arcs (G2 and G3)");
  }
  if (auto used = useOrigin(system_); !used) return used;
  ++moves_;
  if (motion != 0) {
    cuts_ = true;
    noteLengthOffset();
  }
  if (motion > 30) return cycle(block);
  std::array<bool, 3> known = known_;
  const auto to = targetOf(block, known);
  if (!to) return to.error();
  return motion > 10 ? arc(block, *to) : startOrGo(*to, known, motion == 0);
}

ToolPlace GcodeMachine::place(const MachineAxes& at) const {
  ToolPlace place = kinematics_.toolAt(at, length_);
  if (tipControl_) place.tip = Eigen::Vector3d(at[0], at[1], at[2]) - length_;
  return place;
}

Result<void> GcodeMachine::startOrGo(const MachineAxes& to, const std::array<bool, 3>& known,
                                     bool rapid) {
  known_ = known;
  if (builder_.started() && !builder_.isAway()) return straight(to, rapid);
  at_ = to;
  if (!(known_[0] && known_[1] && known_[2])) return {};
  const ToolPlace begin = place(at_);
  if (builder_.started()) return builder_.comeBack(begin.tip, begin.axis);
  builder_.start(begin.tip, begin.axis);
  return {};
}

std::string GcodeMachine::unknownAxes() const {
  std::string axes;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!known_[i]) axes += fmt::format("{}{}", axes.empty() ? "" : " or ", "XYZ"[i]);
  }
  return axes;
}

std::string GcodeMachine::sinceLeftOut() const {
  if (leftOut_ == 0) return " yet";
  return fmt::format(", since line {} moves to a place of the machine", lastLeftOut_);
}

Result<void> GcodeMachine::straight(const MachineAxes& to, bool rapid) {
  const double length = lengthOf(at_, to, 0);
  const double degrees = lengthOf(at_, to, 3);
  double seconds = 0;
  if (rapid) {
    seconds = std::max(60 * length / options_.rapidFeed,
                       degrees / ToolPathBuilder::kTurnDegreesPerSecond);
  } else if (inverseTime_) {
    seconds = 60 / inverseFeed_;
  } else {
    seconds = 60 * (length > ToolPathBuilder::kNoWay ? length / feed_ : degrees / turnFeed_);
  }
  return go(to, seconds, rapid);
}

Result<void> GcodeMachine::go(const MachineAxes& to, double seconds, bool rapid) {
  const double parts = kinematics_.partsOf(at_, to, length_, options_.reach, options_.tolerance);
  if (!(parts <= static_cast<double>(model::kMaxSegments))) {
    return invalid(
        fmt::format("the turn has {:.3g} straight parts of the tolerance {}; allow a larger one",
                    parts, options_.tolerance));
  }
  const MachineAxes from = at_;
  for (double part = 1; part <= parts; ++part) {
    at_ = to;
    if (part < parts) {
      for (std::size_t i = 0; i < 6; ++i) at_[i] = from[i] + part / parts * (to[i] - from[i]);
    }
    const ToolPlace next = place(at_);
    auto moved = builder_.moveTo(next.tip, next.axis, seconds / parts, rapid);
    if (!moved) return moved;
  }
  return {};
}

/// What a line says of an arc in the plane.
Result<ArcWords> GcodeMachine::arcWords(const GcodeBlock& block, const MachineAxes& to) const {
  const auto u = static_cast<std::size_t>(plane_[0]);
  const auto v = static_cast<std::size_t>(plane_[1]);
  const auto w = static_cast<std::size_t>(plane_[2]);
  if (hasRotary(block)) {
    return fail(ErrorCode::Unsupported,
                "an arc with A, B or C is not supported; have straight moves written");
  }
  if (block.centre[w].value_or(0) != 0) {
    return invalid(fmt::format("{} is not in the plane of the arc (G17, G18, G19)", "IJK"[w]));
  }
  ArcWords words;
  words.from = {at_[u], at_[v]};
  words.to = {to[u], to[v]};
  words.clockwise = *motion_ == 20;
  words.turns = block.p.value_or(1);
  if (block.r) words.radius = *block.r * unit_;
  if (!block.centre[u] && !block.centre[v]) return words;
  if (!relativeCentre_ && !(block.centre[u] && block.centre[v])) {
    return invalid("with G90.1 an arc has both numbers of its centre");
  }
  const Eigen::Vector2d given(block.centre[u].value_or(0), block.centre[v].value_or(0));
  const Eigen::Vector2d origin =
      relativeCentre_ ? words.from : Eigen::Vector2d(offsetOf(plane_[0]), offsetOf(plane_[1]));
  words.centre = origin + unit_ * given;
  return words;
}

/// An arc in the plane, straight along the third axis.
Result<void> GcodeMachine::arc(const GcodeBlock& block, const MachineAxes& to) {
  const auto u = static_cast<std::size_t>(plane_[0]);
  const auto v = static_cast<std::size_t>(plane_[1]);
  const auto w = static_cast<std::size_t>(plane_[2]);
  const auto words = arcWords(block, to);
  if (!words) return words.error();
  const auto arc = arcOf(*words);
  if (!arc) return arc.error();
  const auto chords = chordsOfArc(*arc, options_.tolerance);
  if (!chords) return chords.error();
  const auto count = static_cast<double>(*chords);
  const MachineAxes from = at_;
  const double seconds =
      inverseTime_ ? 60 / inverseFeed_ : 60 * std::hypot(arc->length(), to[w] - from[w]) / feed_;
  for (std::uint64_t i = 1; i <= *chords; ++i) {
    MachineAxes next = to;
    if (i < *chords) {
      const double part = static_cast<double>(i) / count;
      const Eigen::Vector2d point = arc->at(part);
      next[u] = point.x();
      next[v] = point.y();
      next[w] = from[w] + part * (to[w] - from[w]);
    }
    if (auto moved = go(next, seconds / count, false); !moved) return moved;
  }
  return {};
}

/// What a line adds to the series of a canned cycle, and whether that is all it needs.
Result<void> GcodeMachine::setSeries(const GcodeBlock& block) {
  const std::string word = gcodeWord(*motion_);
  const auto w = static_cast<std::size_t>(plane_[2]);
  if (hasRotary(block)) return invalid(word + ": a canned cycle does not turn A, B or C");
  if (block.hasCentre()) return invalid("I, J, K and R are for arcs (G2 and G3)");
  if (inverseTime_) return invalid(word + ": a canned cycle has no inverse time (G93)");
  const double repeats = block.l.value_or(1);
  if (!(repeats >= 1 && repeats <= static_cast<double>(model::kMaxSegments)) ||
      repeats != std::floor(repeats)) {
    return invalid(fmt::format("{}: L{:g} is not a whole number from 1 to {}", word, repeats,
                               model::kMaxSegments));
  }
  if (!series_) series_ = Series{.level = at_[w]};
  if (series_->code != *motion_) series_ = Series{.code = *motion_, .level = series_->level};
  if (block.r) series_->clear = *block.r * unit_;
  if (block.axes[w]) series_->bottom = *block.axes[w] * unit_;
  if (block.q) series_->peck = *block.q * unit_;
  if (!series_->clear || !series_->bottom) {
    return invalid(fmt::format("{} has no {}", word,
                               series_->clear ? std::string(1, "XYZ"[w]) + ", the bottom"
                                              : "R, the height where feed begins"));
  }
  const bool pecks = *motion_ == 730 || *motion_ == 830;
  if (pecks && !(series_->peck.value_or(0) > 0)) {
    return invalid(fmt::format("{} has no Q above zero, the depth of a peck", word));
  }
  dwells_ += *motion_ == 820 || *motion_ == 890 ? 1 : 0;
  return {};
}

Result<void> GcodeMachine::cycle(const GcodeBlock& block) {
  if (auto set = setSeries(block); !set) return set;
  const auto w = static_cast<std::size_t>(plane_[2]);
  const auto toHeight = [&](double height, bool rapid) {
    MachineAxes to = at_;
    to[w] = height;
    return straight(to, rapid);
  };
  double level = retractsToClear_ ? at_[w] : series_->level;
  const double offset = offsetOf(plane_[2]);
  CycleHole hole{.code = *motion_, .peck = series_->peck.value_or(0)};
  hole.clear = *series_->clear + (relative_ ? level : offset);
  hole.bottom = *series_->bottom + (relative_ ? hole.clear : offset);
  if (hole.clear < hole.bottom) {
    return invalid(fmt::format("{}: R is {:.6g} mm below {}, the bottom", gcodeWord(*motion_),
                               hole.bottom - hole.clear, "XYZ"[w]));
  }
  if (level < hole.clear) {
    level = hole.clear;
    if (auto moved = toHeight(level, true); !moved) return moved;
  }
  hole.retract = retractsToClear_ ? hole.clear : level;
  for (double i = 0; i < block.l.value_or(1); ++i) {
    MachineAxes to = at_;
    to[w] = level;
    for (const int axis : {plane_[0], plane_[1]}) {
      const auto& given = block.axes[static_cast<std::size_t>(axis)];
      auto& place = to[static_cast<std::size_t>(axis)];
      if (given) place = *given * unit_ + (relative_ ? place : offsetOf(axis));
    }
    if (auto moved = straight(to, true); !moved) return moved;
    if (auto moved = toHeight(hole.clear, true); !moved) return moved;
    if (auto moved = visitCycle(hole, toHeight); !moved) return moved;
    level = hole.retract;
  }
  return {};
}

}  // namespace t4d::formats
