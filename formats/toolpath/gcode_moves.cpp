#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "formats/toolpath/gcode_arc.h"
#include "formats/toolpath/gcode_cycles.h"
#include "formats/toolpath/gcode_machine.h"
#include "model/degrees.h"

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

/// @ and ^, or X and Y after G16: in the plane, from the origin of the program.
Eigen::Vector2d GcodeMachine::polar(const GcodeBlock& block, const MachineAxes& at) const {
  const auto u = static_cast<std::size_t>(modes_.plane[0]);
  const auto v = static_cast<std::size_t>(modes_.plane[1]);
  const Eigen::Vector2d origin(offsetOf(modes_.plane[0]), offsetOf(modes_.plane[1]));
  const Eigen::Vector2d from = Eigen::Vector2d(at[u], at[v]) - origin;
  double radius = from.norm();
  double degrees = model::kDegreesPerRadian * std::atan2(from.y(), from.x());
  const auto& givenRadius = modes_.polar ? block.axes[u] : block.radius;
  const auto& givenAngle = modes_.polar ? block.axes[v] : block.angle;
  if (givenRadius) radius = *givenRadius * modes_.unit + (modes_.relative ? radius : 0);
  if (givenAngle) degrees = *givenAngle + (modes_.relative ? degrees : 0);
  const double angle = degrees / model::kDegreesPerRadian;
  return origin + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
}

/// Where a line goes from there, and which of X, Y and Z it gives.
Result<MachineAxes> GcodeMachine::targetOf(const GcodeBlock& block, const MachineAxes& from,
                                           std::array<bool, 3>& known) const {
  MachineAxes to = from;
  for (int axis = 0; axis < 6; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    if (!block.axes[i]) continue;
    if (modes_.relative && axis < 3 && !known_[i]) {
      return invalid(
          fmt::format("{} is relative (G91) where it is not known{}", "XYZ"[axis], sinceLeftOut()));
    }
    to[i] = *block.axes[i] * unitOf(axis) + (modes_.relative ? from[i] : offsetOf(axis));
    if (axis < 3) known[i] = true;
  }
  const auto u = static_cast<std::size_t>(modes_.plane[0]);
  const auto v = static_cast<std::size_t>(modes_.plane[1]);
  if (block.radius || block.angle || (modes_.polar && (block.axes[u] || block.axes[v]))) {
    const Eigen::Vector2d place = polar(block, from);
    to[u] = place.x();
    to[v] = place.y();
    known[u] = known[v] = true;
  }
  return to;
}

Result<void> GcodeMachine::checkCut(bool cuts) {
  if (!cuts) return {};
  if (builder_.isAway()) {
    return invalid(fmt::format("a cutting move where {} is not known{}; give it by G0 before, or "
                               "say where the machine's zero is",
                               unknownAxes(), sinceLeftOut()),
                   {}, Remedy::MachineZero);
  }
  if (modes_.inverseTime && !(inverseFeed_ > 0)) {
    return invalid("a cutting move with inverse time (G93) has no F in its line");
  }
  const bool threads = motion_ == 330 || motion_ == 331;
  if (!modes_.inverseTime && !(feedOf() > 0) && !threads) {
    return invalid(modes_.perTurn && modes_.feed > 0
                       ? "a cutting move with feed per turn (G95) has no S, the turns per minute"
                       : "a cutting move has no feed; give F before, or --feed");
  }
  if (options_.tools && mounted_.value_or(0) == 0) {
    return invalid("a cutting move comes before a tool is mounted (T1 M6)", {}, Remedy::AnyTool);
  }
  return {};
}

/// The tool is where it was before the program, in the axes that have not been given.
Result<void> GcodeMachine::beginAtStart() {
  model::Point3 start = options_.assumedStart;
  if (machineZero_)
    start = Eigen::Vector3d((*machineZero_)[0], (*machineZero_)[1], (*machineZero_)[2]);
  std::string axes;
  for (std::size_t i = 0; i < 3; ++i) {
    if (known_[i]) continue;
    at_[i] = start[static_cast<Eigen::Index>(i)];
    assumed_[i] = true;
    axes += fmt::format("{}{}", axes.empty() ? "" : ", ", "XYZ"[i]);
  }
  known_ = {true, true, true};
  notes_.emplace_back(
      line_,
      fmt::format("{} {} not been given before: the tool begins at ({:.6g}, {:.6g}, {:.6g}) "
                  "mm, {}; --start X,Y,Z says where",
                  axes, axes.size() > 1 ? "have" : "has", start.x(), start.y(), start.z(),
                  machineZero_ ? "the zero of the machine" : "the middle of the stock's top"));
  tool_ = at_;
  const ToolPlace begin = place(tool_);
  builder_.start(begin.tip, begin.axis);
  return {};
}

Result<void> GcodeMachine::move(const GcodeBlock& block) {
  if (!motion_) motion_ = 0;  // as GRBL begins
  const int motion = *motion_;
  const bool cuts = motion != 0;
  if (auto good = checkCut(cuts); !good) return good;
  const bool arcs = motion == 20 || motion == 30;
  const bool splines = motion == 50 || motion == 51 || motion == 52;
  const bool threads = motion == 330 || motion == 331;
  if (!arcs && !splines && !threads && motion < 730 && (block.hasCentre() || block.r)) {
    return invalid("I, J, K and R are for arcs (G2 and G3)");
  }
  if (auto used = useOrigin(modes_.system); !used) return used;
  const bool needsPlace = cuts || modes_.relative || block.radius || block.angle || modes_.polar;
  if (!builder_.started() && needsPlace) {
    if (auto begun = beginAtStart(); !begun) return begun;
  }
  ++moves_;
  if (cuts) {
    cuts_ = true;
    noteLengthOffset();
  }
  if (motion >= 730) return cycle(block);
  std::array<bool, 3> known = known_;
  const auto to = targetOf(block, at_, known);
  if (!to) return to.error();
  const bool approaches = comesFromStart(block) && cuts;
  if (approaches) {
    notes_.emplace_back(line_, "the way there from where the tool begins is drawn as a rapid move");
  }
  if (corner_ && motion != 10) return invalid(missingAfterCorner());
  if (arcs) return arc(block, *to, approaches);
  if (motion == 52) return addNurbsPoint(block, *to);
  if (splines) return spline(block, *to, approaches);
  if (threads) return thread(block, *to);
  if (block.corner || block.chamfer || corner_) return turnCorner(block, *to);
  return startOrGo(*to, known, !cuts || approaches);
}

/// Whether a move comes from where the program has not said that the tool is. It has from then on.
bool GcodeMachine::comesFromStart(const GcodeBlock& block) {
  bool found = false;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!block.axes[i] || modes_.relative) continue;
    found = found || assumed_[i];
    assumed_[i] = false;
  }
  return found;
}

ToolPlace GcodeMachine::place(const MachineAxes& at) const {
  const MachineAxes turned = turnedAxes(at);
  ToolPlace place = kinematics_.toolAt(turned, length_);
  if (tipControl_) place.tip = Eigen::Vector3d(turned[0], turned[1], turned[2]) - length_;
  return place;
}

Result<void> GcodeMachine::startOrGo(const MachineAxes& to, const std::array<bool, 3>& known,
                                     bool rapid) {
  known_ = known;
  if (builder_.started() && !builder_.isAway()) return straight(to, rapid);
  at_ = tool_ = to;
  if (!(known_[0] && known_[1] && known_[2])) return {};
  const ToolPlace begin = place(tool_);
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

double GcodeMachine::lengthBetween(const MachineAxes& from, const MachineAxes& to) const {
  return lengthOf(turnedAxes(from), turnedAxes(to), 0);
}

/// From where the tool is, and what the program is turned and scaled to.
double GcodeMachine::secondsOf(const MachineAxes& to, bool rapid) const {
  const double length = lengthBetween(tool_, to);
  const double degrees = lengthOf(tool_, to, 3);
  if (rapid) {
    return std::max(60 * length / options_.rapidFeed,
                    degrees / ToolPathBuilder::kTurnDegreesPerSecond);
  }
  if (modes_.inverseTime) return 60 / inverseFeed_;
  const bool moves = length > ToolPathBuilder::kNoWay;
  return 60 * (moves ? length / feedOf() : degrees / modes_.turnFeed);
}

Result<void> GcodeMachine::straight(const MachineAxes& to, bool rapid) {
  if (!compensation_) return go(to, secondsOf(to, rapid), rapid);
  const double length = lengthOf(at_, to, 0);
  const double feed = rapid                ? options_.rapidFeed
                      : modes_.inverseTime ? length * inverseFeed_
                                           : feedOf();
  auto done = compensation_->straight(to, rapid, feed);
  at_ = to;
  return done;
}

Result<void> GcodeMachine::go(const MachineAxes& to, double seconds, bool rapid) {
  const double parts = kinematics_.partsOf(turnedAxes(tool_), turnedAxes(to), length_,
                                           options_.reach, options_.tolerance);
  if (!(parts <= static_cast<double>(model::kMaxSegments))) {
    return invalid(
        fmt::format("the turn has {:.3g} straight parts of the tolerance {}; allow a larger one",
                    parts, options_.tolerance));
  }
  const MachineAxes from = tool_;
  for (double part = 1; part <= parts; ++part) {
    tool_ = to;
    if (part < parts) {
      for (std::size_t i = 0; i < 6; ++i) tool_[i] = from[i] + part / parts * (to[i] - from[i]);
    }
    const ToolPlace next = place(tool_);
    auto moved = builder_.moveTo(next.tip, next.axis, seconds / parts, rapid);
    if (!moved) return moved;
  }
  at_ = tool_;
  return {};
}

/// What a line says of an arc in the plane.
Result<ArcWords> GcodeMachine::arcWords(const GcodeBlock& block, const MachineAxes& to) const {
  const auto u = static_cast<std::size_t>(modes_.plane[0]);
  const auto v = static_cast<std::size_t>(modes_.plane[1]);
  const auto w = static_cast<std::size_t>(modes_.plane[2]);
  if (hasRotary(block)) {
    return fail(ErrorCode::Unsupported,
                "an arc with A, B or C is not supported; have straight moves written");
  }
  if (block.centre[w].value_or(0) != 0) {
    return invalid(fmt::format("{} is not in the plane of the arc (G17, G18, G19)", "IJK"[w]));
  }
  ArcWords words;
  words.unit = modes_.unit;
  words.from = {at_[u], at_[v]};
  words.to = {to[u], to[v]};
  words.clockwise = *motion_ == 20;
  words.turns = block.p.value_or(1);
  if (block.r) words.radius = *block.r * modes_.unit;
  if (!block.centre[u] && !block.centre[v]) return words;
  if (!modes_.relativeCentre && !(block.centre[u] && block.centre[v])) {
    return invalid("with G90.1 an arc has both numbers of its centre");
  }
  const Eigen::Vector2d given(block.centre[u].value_or(0), block.centre[v].value_or(0));
  const Eigen::Vector2d origin =
      modes_.relativeCentre ? words.from
                            : Eigen::Vector2d(offsetOf(modes_.plane[0]), offsetOf(modes_.plane[1]));
  words.centre = origin + modes_.unit * given;
  return words;
}

/// An arc in the plane, straight along the third axis.
Result<void> GcodeMachine::arc(const GcodeBlock& block, const MachineAxes& to, bool approaches) {
  const auto w = static_cast<std::size_t>(modes_.plane[2]);
  if (scale_ &&
      std::abs(scale_->factors[modes_.plane[0]]) != std::abs(scale_->factors[modes_.plane[1]])) {
    return fail(ErrorCode::Unsupported,
                "an arc is not supported where G51 scales the axes of its plane differently");
  }
  const auto words = arcWords(block, to);
  if (!words) return words.error();
  const auto arc = arcOf(*words);
  if (!arc) return arc.error();
  if (compensation_) {
    const double length = std::hypot(arc->length(), to[w] - at_[w]);
    auto done =
        compensation_->arc(*words, to, modes_.inverseTime ? length * inverseFeed_ : feedOf());
    at_ = to;
    return done;
  }
  if (tool_ != at_) return invalid("an arc comes directly after G40; give a straight move before");
  const double length = scaleInPlane() * std::hypot(arc->length(), to[w] - at_[w]);
  const double seconds = approaches           ? 60 * length / options_.rapidFeed
                         : modes_.inverseTime ? 60 / inverseFeed_
                                              : 60 * length / feedOf();
  return goAlong(*arc, to, seconds, approaches);
}

/// By which G51 makes arcs of the plane longer.
double GcodeMachine::scaleInPlane() const {
  return scale_ ? std::abs(scale_->factors[modes_.plane[0]]) : 1;
}

Result<void> GcodeMachine::goAlong(const Arc& arc, const MachineAxes& to, double seconds,
                                   bool rapid) {
  const auto u = static_cast<std::size_t>(modes_.plane[0]);
  const auto v = static_cast<std::size_t>(modes_.plane[1]);
  const auto w = static_cast<std::size_t>(modes_.plane[2]);
  const auto chords = chordsOfArc(arc, options_.tolerance / scaleInPlane());
  if (!chords) return chords.error();
  const auto count = static_cast<double>(*chords);
  const MachineAxes from = tool_;
  for (std::uint64_t i = 1; i <= *chords; ++i) {
    MachineAxes next = to;
    if (i < *chords) {
      const double part = static_cast<double>(i) / count;
      const Eigen::Vector2d point = arc.at(part);
      next[u] = point.x();
      next[v] = point.y();
      next[w] = from[w] + part * (to[w] - from[w]);
    }
    if (auto moved = go(next, seconds / count, rapid); !moved) return moved;
  }
  return {};
}

/// G33, K along for each turn of the spindle, and G33.1, which comes back.
Result<void> GcodeMachine::thread(const GcodeBlock& block, const MachineAxes& to) {
  const double feed = std::abs(block.centre[2].value_or(0)) * modes_.unit * modes_.spindle;
  if (!(feed > 0)) {
    return invalid(gcodeWord(*motion_) + " has no K, the way of a turn, or no S before it");
  }
  if (compensation_)
    return invalid(gcodeWord(*motion_) + " stands where the cutter is compensated");
  const MachineAxes from = tool_;
  const double seconds = 60 * lengthBetween(from, to) / feed;
  auto done = go(to, seconds, false);
  return done && *motion_ == 331 ? go(from, seconds, false) : done;
}

/// L, or K of other controls than LinuxCNC: how often a cycle comes.
double GcodeMachine::repeatsOf(const GcodeBlock& block) const {
  const auto w = static_cast<std::size_t>(modes_.plane[2]);
  return block.l.value_or(block.centre[w].value_or(1));
}

/// What a line adds to the series of a canned cycle, and whether that is all it needs.
Result<void> GcodeMachine::setSeries(const GcodeBlock& block) {
  const std::string word = gcodeWord(*motion_);
  const auto w = static_cast<std::size_t>(modes_.plane[2]);
  if (hasRotary(block)) return invalid(word + ": a canned cycle does not turn A, B or C");
  if (block.centre[0] || block.centre[1]) return invalid("I and J are for arcs (G2 and G3)");
  if (compensation_) return invalid(word + " stands where the cutter is compensated; give G40");
  if (modes_.inverseTime) return invalid(word + ": a canned cycle has no inverse time (G93)");
  const double repeats = repeatsOf(block);
  if (!(repeats >= 0 && repeats <= static_cast<double>(model::kMaxSegments)) ||
      repeats != std::floor(repeats)) {
    return invalid(fmt::format("{}: L{:g} is not a whole number up to {}", word, repeats,
                               model::kMaxSegments));
  }
  if (habits_.guessed) {
    habits_.guessed = false;
    notes_.emplace_back(line_,
                        "the program looks like one of Fanuc's controls, so that cycles begin with "
                        "G98; --dialect linuxcnc begins with G99");
  }
  if (!series_) series_ = Series{.level = at_[w]};
  if (series_->code != *motion_) series_ = Series{.code = *motion_, .level = series_->level};
  if (block.r) series_->clear = *block.r * modes_.unit;
  if (block.axes[w]) series_->bottom = *block.axes[w] * modes_.unit;
  if (block.q) series_->peck = *block.q * modes_.unit;
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
  const auto w = static_cast<std::size_t>(modes_.plane[2]);
  const auto toHeight = [&](double height, bool rapid) {
    MachineAxes to = at_;
    to[w] = height;
    return straight(to, rapid);
  };
  double level = modes_.retractsToClear ? at_[w] : series_->level;
  const double offset = offsetOf(modes_.plane[2]);
  CycleHole hole{.code = *motion_, .peck = series_->peck.value_or(0)};
  // As LinuxCNC, from where the series began.
  hole.clear = *series_->clear + (modes_.relative ? series_->level : offset);
  hole.bottom = *series_->bottom + (modes_.relative ? hole.clear : offset);
  if (hole.clear < hole.bottom) {
    return invalid(fmt::format("{}: R is {:.6g} mm below {}, the bottom", gcodeWord(*motion_),
                               hole.bottom - hole.clear, "XYZ"[w]));
  }
  if (level < hole.clear) {
    level = hole.clear;
    if (auto moved = toHeight(level, true); !moved) return moved;
  }
  hole.retract = modes_.retractsToClear ? hole.clear : level;
  for (double i = 0; i < repeatsOf(block); ++i) {
    GcodeBlock inPlane = block;
    inPlane.axes[w].reset();
    std::array<bool, 3> known = known_;
    const auto target = targetOf(inPlane, at_, known);
    if (!target) return target.error();
    MachineAxes to = *target;
    to[w] = level;
    if (auto moved = straight(to, true); !moved) return moved;
    if (auto moved = toHeight(hole.clear, true); !moved) return moved;
    if (auto moved = visitCycle(hole, toHeight); !moved) return moved;
    level = hole.retract;
  }
  return {};
}

}  // namespace t4d::formats
