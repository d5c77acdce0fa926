#include "formats/toolpath/gcode_machine.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "model/amount_text.h"

namespace t4d::formats {
namespace {

constexpr double kMmPerInch = 25.4;
constexpr int kLargestTool = 99'999;

bool isCycle(int motion) { return motion >= 730; }

}  // namespace

GcodeMachine::GcodeMachine(const ToolPathOptions& options, const GcodeHabits& habits)
    : options_(options),
      habits_(habits),
      kinematics_(options.rotaries),
      builder_(options),
      tipControl_(options.tipControl) {
  modes_.retractsToClear = !habits.retractsToLevel;
  const auto axesOf = [](const model::Point3& point) {
    return MachineAxes{point.x(), point.y(), point.z(), 0, 0, 0};
  };
  for (const auto& [code, point] : options.offsets) {
    if (code == 530) {
      machineZero_ = axesOf(point);
    } else if (code >= 540) {
      const int system = code <= 590 ? (code - 540) / 10 : code - 590 + 5;
      origins_[static_cast<std::size_t>(system)] = axesOf(point);
    }
  }
  if (options.start) {
    std::copy_n(options.start->data(), 3, at_.begin());
    tool_ = at_;
    known_ = {true, true, true};
    const ToolPlace begin = place(at_);
    builder_.start(begin.tip, begin.axis);
  }
  if (!machineZero_) return;
  for (const int code : {280, 300}) {
    const auto stated = options.offsets.find(code);
    const model::Point3 point =
        stated == options.offsets.end() ? model::Point3::Zero().eval() : stated->second;
    auto& reference = references_[code == 280 ? 0 : 1];
    reference = axesOf(point);
    for (std::size_t i = 0; i < 3; ++i) (*reference)[i] += (*machineZero_)[i];
  }
}

Result<void> GcodeMachine::apply(const GcodeBlock& given, std::uint64_t line, std::size_t depth) {
  line_ = line;
  if (given.isMacro) return {};  // its letters are arguments
  keepModes(given, depth);
  GcodeBlock block = given;
  takeWholeNumbers(block);
  if (auto good = checkWords(block); !good) return good;
  if (auto good = checkHeldMoves(block); !good) return good;
  if (auto done = setFeed(block); !done) return done;
  if (const auto units = block.code(GcodeGroup::Units)) {
    modes_.unit = *units == 200 ? kMmPerInch : 1;
  }
  if (auto done = setTool(block); !done) return done;
  if (auto done = setModes(block); !done) return done;
  if (block.code(GcodeGroup::Scale) || block.code(GcodeGroup::Mirror) ||
      block.code(GcodeGroup::Rotation)) {
    if (auto done = setTurns(block); !done) return done;
    // Their axes are points, and no moves.
    if (block.hasAxes()) return {};
  }
  if (const auto motion = block.code(GcodeGroup::Motion)) {
    if (isCycle(*motion) && !(motion_ && isCycle(*motion_))) motionBefore_ = motion_;
    motion_ = motion;
    if (nurbs_ && motion != 52 && motion != 53) return invalid("G5.2 is not ended, by G5.3");
    if (motion == 53) return endNurbs();
    if (motion == 52 && !block.hasAxes()) return addNurbsPoint(block, at_);
  }
  const bool cycles = motion_ && isCycle(*motion_);
  if (!cycles) series_.reset();
  if (const auto code = block.code(GcodeGroup::NonModal)) {
    auto done = applyNonModal(*code, block);
    turnAgain();
    return done;
  }
  if (const auto code = block.code(GcodeGroup::ToolLength); code == 431 || code == 432) return {};
  if (block.hasAxes() || block.hasCentre() || (block.r && !cycles)) return move(block);
  if (cycles && block.code(GcodeGroup::Motion)) {
    return invalid(fmt::format("{} stands without X, Y or Z", gcodeWord(*motion_)));
  }
  return {};
}

/// Refuses what goes elsewhere, in another plane or with another tool, while the end of the last
/// move waits for the next one.
Result<void> GcodeMachine::checkHeldMoves(const GcodeBlock& block) const {
  const auto code = block.code(GcodeGroup::NonModal);
  const auto plane = block.code(GcodeGroup::Plane);
  const int now = modes_.plane[2] == 2 ? 170 : modes_.plane[2] == 1 ? 180 : 190;
  const bool leaves = block.changesTool || block.namesTool || code == 280 || code == 300 ||
                      code == 530 || (plane && *plane != now);
  if (!leaves) return {};
  if (corner_) return invalid(missingAfterCorner());
  if (compensation_) {
    return invalid(
        "a tool, a plane or a place of the machine is chosen where the cutter is compensated; give "
        "G40 before");
  }
  return {};
}

/// M70 to M73, and the end of subprograms that had M73.
void GcodeMachine::keepModes(const GcodeBlock& block, std::size_t depth) {
  while (!saved_.empty() && saved_.rbegin()->first > depth) {
    const auto last = std::prev(saved_.end());
    if (last->second.restores) modes_ = last->second.modes;
    saved_.erase(last);
  }
  const auto saved = saved_.find(depth);
  if (block.saves == 70 || block.saves == 73) saved_[depth] = {modes_, block.saves == 73};
  if (saved == saved_.end()) return;
  if (block.saves == 71) saved_.erase(saved);
  if (block.saves == 72) modes_ = saved->second.modes;
}

/// Numbers without a point count thousandths of a millimetre, or ten thousandths of an inch.
void GcodeMachine::takeWholeNumbers(GcodeBlock& block) {
  if (!habits_.wholeThousandths || block.namesTool || block.code(GcodeGroup::NonModal) == 40) {
    return;
  }
  const auto units = block.code(GcodeGroup::Units);
  const bool inches = units ? *units == 200 : modes_.unit != 1;
  const auto take = [&](char letter, std::optional<double>& value) {
    if (!value || *value == 0 || !block.isWhole(letter)) return;
    *value *= inches && letter > 'C' ? 1e-4 : 1e-3;
    if (wholeNumbers_++ == 0) firstWhole_ = line_;
  };
  for (std::size_t i = 0; i < 6; ++i) take("XYZABC"[i], block.axes[i]);
  for (std::size_t i = 0; i < 3; ++i) take("IJK"[i], block.centre[i]);
  take('R', block.r);
  take('Q', block.q);
}

/// Refuses words that nothing in the line reads.
Result<void> GcodeMachine::checkWords(const GcodeBlock& block) const {
  const auto motion = block.code(GcodeGroup::Motion).value_or(motion_.value_or(0));
  const auto nonModal = block.code(GcodeGroup::NonModal);
  const bool moves = block.hasAxes() || block.hasCentre() || block.r;
  const bool others = nonModal && nonModal != 40;
  const bool arcs = moves && !others && (motion == 20 || motion == 30);
  const bool splines = !others && motion >= 50 && motion <= 53;
  const bool cycles = block.hasAxes() && !others && isCycle(motion);
  const bool blends = block.code(GcodeGroup::Path) == 640;
  const bool sets = nonModal == 100;
  const bool scales = block.code(GcodeGroup::Scale) == 510;
  const bool free = block.talks || block.calls;
  if (block.p && !arcs && !splines && !cycles && !blends && !sets && !scales && nonModal != 40 &&
      !free) {
    return invalid(
        fmt::format("P{:g} stands without G2, G3, G4, G10, G64, M98 or a canned cycle", *block.p));
  }
  if (block.q && !splines && !cycles && !blends && !block.namesTool && !free) {
    return invalid(fmt::format("Q{:g} stands without G64, M61 or a canned cycle", *block.q));
  }
  if (block.l && !cycles && !sets && !splines && !free) {
    return invalid(fmt::format("L{:g} stands without G10, M98 or a canned cycle", *block.l));
  }
  if (block.r && isCycle(motion) && !cycles && !sets && block.code(GcodeGroup::Rotation) != 680) {
    return invalid(fmt::format("R{:g} stands without X, Y or Z", *block.r));
  }
  const auto length = block.code(GcodeGroup::ToolLength);
  if (block.h && !options_.lengths.empty() && (!length || length == 431)) {
    return invalid(fmt::format("H{:g} stands without G43", *block.h));
  }
  if ((block.corner || block.chamfer) && (motion != 10 || others)) {
    return invalid(fmt::format("{} stands without G1", block.corner ? ",R" : ",C"));
  }
  return checkRotaries(block);
}

/// An axis that stays at zero need not be known.
Result<void> GcodeMachine::checkRotaries(const GcodeBlock& block) const {
  for (int axis = 3; axis < 6; ++axis) {
    const double value = block.axes[static_cast<std::size_t>(axis)].value_or(0);
    if (value == 0 || kinematics_.turns(axis)) continue;
    return fail(ErrorCode::Unsupported,
                fmt::format("{}{:g} is not supported: it is a rotary axis; say how the machine "
                            "turns, or give cutter locations (GOTO/x,y,z,i,j,k)",
                            "XYZABC"[axis], value),
                {}, Remedy::RotaryAxis);
  }
  return {};
}

/// As LinuxCNC, before units change.
Result<void> GcodeMachine::setFeed(const GcodeBlock& block) {
  if (const auto mode = block.code(GcodeGroup::FeedMode)) {
    const bool inverse = *mode == 930;
    const bool perTurn = *mode == 950;
    if (inverse != modes_.inverseTime || perTurn != modes_.perTurn) modes_.feed = 0;
    modes_.inverseTime = inverse;
    modes_.perTurn = perTurn;
  }
  if (block.s) modes_.spindle = std::abs(*block.s);
  inverseFeed_ = 0;
  if (!block.f) return {};
  if (!(*block.f >= 0)) return invalid(fmt::format("the feed is {:g}", *block.f));
  if (modes_.inverseTime) {
    inverseFeed_ = *block.f;
    return {};
  }
  modes_.feed = *block.f * modes_.unit;
  modes_.turnFeed = *block.f;
  const auto units = block.code(GcodeGroup::Units);
  const double next = units == 200 ? kMmPerInch : 1;
  if (units && next != modes_.unit && *block.f > 0) {
    notes_.emplace_back(
        line_, fmt::format("F{:g} stands in the line of {} and counts before it, as in LinuxCNC: "
                           "{:g} mm/min; on other controls it is {:g} mm/min",
                           *block.f, gcodeWord(*units), modes_.feed, *block.f * next));
  }
  return {};
}

double GcodeMachine::feedOf() const {
  const double feed = modes_.perTurn ? modes_.feed * modes_.spindle : modes_.feed;
  return feed > 0 ? feed : options_.defaultFeed.value_or(0);
}

Result<void> GcodeMachine::setTool(const GcodeBlock& block) {
  if (block.t) selected_ = *block.t;
  if (block.namesTool) {
    if (!block.q) return invalid("M61 has no Q, the number of the tool");
    return mount(*block.q);
  }
  return block.changesTool ? mount(selected_) : Result<void>();
}

Result<void> GcodeMachine::mount(double tool) {
  if (mounted_ == tool) return {};
  if (!options_.tools && cuts_) {
    return fail(ErrorCode::Unsupported,
                fmt::format("a second tool is mounted (T{:g}), and one is given for all", tool), {},
                Remedy::EachTool);
  }
  const auto number = tool == std::floor(tool) && tool >= 0 && tool <= kLargestTool
                          ? static_cast<int>(tool)
                          : kLargestTool + 1;
  Eigen::Vector3d length = Eigen::Vector3d::Zero();
  if (const auto found = options_.lengths.find(number); found != options_.lengths.end()) {
    length = found->second;
  } else if (!options_.lengths.empty() && number != 0) {
    return invalid(fmt::format("T{:g} is mounted, and it is not in the tool table", tool));
  }
  mounted_ = tool;
  notedLength_ = false;
  const bool isElsewhere = length != length_ && builder_.started() && !builder_.isAway();
  length_ = length;
  if (isElsewhere) builder_.leave();
  auto taken = builder_.mount(number == 0 ? std::nullopt : std::optional(number));
  if (!taken || !isElsewhere) return taken;
  const ToolPlace next = place(tool_);
  return builder_.comeBack(next.tip, next.axis);
}

Result<void> GcodeMachine::setModes(const GcodeBlock& block) {
  if (block.code(GcodeGroup::Cancel) && motion_ && isCycle(*motion_)) {
    motion_ = motionBefore_;
    series_.reset();
  }
  if (const auto plane = block.code(GcodeGroup::Plane)) {
    modes_.plane = *plane == 170   ? std::array{0, 1, 2}
                   : *plane == 180 ? std::array{2, 0, 1}
                                   : std::array{1, 2, 0};
    series_.reset();
  }
  if (const auto origin = block.code(GcodeGroup::Origin)) {
    modes_.system =
        static_cast<std::size_t>(*origin <= 590 ? (*origin - 540) / 10 : *origin - 590 + 5);
  }
  if (const auto distance = block.code(GcodeGroup::Distance)) modes_.relative = *distance == 910;
  if (const auto centres = block.code(GcodeGroup::Centres)) modes_.relativeCentre = *centres == 911;
  if (const auto retract = block.code(GcodeGroup::Retract)) {
    modes_.retractsToClear = *retract == 990;
    habits_.guessed = false;  // it no longer matters
  }
  if (const auto polar = block.code(GcodeGroup::Polar)) modes_.polar = *polar == 160;
  const auto length = block.code(GcodeGroup::ToolLength);
  if (length) {
    if (auto done = setToolLength(*length, block); !done) return done;
  }
  turnAgain();
  const auto compensation = block.code(GcodeGroup::Compensation);
  return compensation ? setCompensation(*compensation, block) : Result<void>();
}

Result<void> GcodeMachine::setToolLength(Tenths code, const GcodeBlock& block) {
  if (code == 490) {
    lengthOffset_.setZero();
    controlTip(options_.tipControl);
    return {};
  }
  if (code == 434) controlTip(true);
  const bool tips = options_.lengths.empty();  // are programmed
  if (code == 431) {
    if (tips) {
      return fail(ErrorCode::Unsupported,
                  "G43.1 is not supported where lengths of tools are not known", {},
                  Remedy::ToolTable);
    }
    for (int i = 0; i < 3; ++i) {
      if (const auto& given = block.axes[static_cast<std::size_t>(i)]) {
        lengthOffset_[i] = *given * modes_.unit;
      }
    }
    return {};
  }
  if (tips) return {};
  const double number = block.h.value_or(mounted_.value_or(0));
  const auto found = options_.lengths.find(static_cast<int>(number));
  const bool known = found != options_.lengths.end() && number == found->first;
  if (!known && number != 0) {
    return invalid(fmt::format("{} H{:g}: there is no tool {:g} in the tool table", gcodeWord(code),
                               number, number));
  }
  const Eigen::Vector3d offset = known ? found->second : Eigen::Vector3d::Zero().eval();
  lengthOffset_ = code == 432 ? (lengthOffset_ + offset).eval() : offset;
  return {};
}

void GcodeMachine::controlTip(bool on) {
  if (on == tipControl_) return;
  const bool turned =
      std::any_of(at_.begin() + 3, at_.end(), [](double angle) { return angle != 0; });
  if (turned && !(known_[0] && known_[1] && known_[2])) known_ = {};
  if (on) {
    const model::Point3 control = place(at_).tip + length_;
    std::copy_n(control.data(), 3, at_.begin());
  } else {
    const model::Point3 tip = place(at_).tip;
    at_ = kinematics_.positionOf(tip, at_, length_);
  }
  tool_ = at_;
  tipControl_ = on;
}

std::optional<double> GcodeMachine::parameter(int number) const {
  const auto within = [&](int first, int count) {
    return number >= first && number < first + count;
  };
  const auto unitless = [&](double value, int axis) { return value / unitOf(axis); };
  if (number == 5220) return static_cast<double>(modes_.system + 1);
  if (number == 5400) return mounted_.value_or(0);
  if (within(5401, 3)) return unitless(lengthOffset_[number - 5401], 0);
  if (within(5211, 6))
    return unitless(shift_[static_cast<std::size_t>(number - 5211)], number - 5211);
  if (within(5420, 6)) {
    const int axis = number - 5420;
    if (axis < 3 && !known_[static_cast<std::size_t>(axis)]) return std::nullopt;
    return unitless(at_[static_cast<std::size_t>(axis)] - offsetOf(axis), axis);
  }
  if (within(5221, 180) && (number - 5221) % 20 < 6 && machineZero_) {
    const auto& origin = origins_[static_cast<std::size_t>((number - 5221) / 20)];
    const int axis = (number - 5221) % 20;
    const auto i = static_cast<std::size_t>(axis);
    if (origin) return unitless((*origin)[i] - (*machineZero_)[i], axis);
  }
  return std::nullopt;
}

std::optional<double> GcodeMachine::parameter(const std::string& name) const {
  constexpr std::array<std::string_view, 6> kPositions = {"_X", "_Y", "_Z", "_A", "_B", "_C"};
  const auto position = std::ranges::find(kPositions, name);
  if (position != kPositions.end()) {
    return parameter(5420 + static_cast<int>(position - kPositions.begin()));
  }
  if (name == "_LINE") return static_cast<double>(line_);
  if (name == "_METRIC") return modes_.unit == 1 ? 1 : 0;
  if (name == "_IMPERIAL") return modes_.unit == 1 ? 0 : 1;
  if (name == "_ABSOLUTE") return modes_.relative ? 0 : 1;
  if (name == "_INCREMENTAL") return modes_.relative ? 1 : 0;
  if (name == "_PLANE") return modes_.plane[2] == 2 ? 170 : modes_.plane[2] == 1 ? 180 : 190;
  if (name == "_FEED") return modes_.feed / modes_.unit;
  if (name == "_CURRENT_TOOL") return mounted_.value_or(0);
  if (name == "_SELECTED_TOOL") return selected_;
  if (name == "_COORD_SYSTEM")
    return modes_.system < 6 ? 540 + 10 * modes_.system : 585 + modes_.system;
  return std::nullopt;
}

/// Once for each tool that is mounted.
void GcodeMachine::noteLengthOffset() {
  if (notedLength_ || options_.lengths.empty() || (lengthOffset_ - length_).norm() < 1e-9) return;
  notedLength_ = true;
  notes_.emplace_back(line_,
                      fmt::format("T{:g} cuts with a length offset of {:g} (G43), and is {:g} long "
                                  "in the tool table: its tip is {:g} lower than programmed",
                                  mounted_.value_or(0), lengthOffset_.z(), length_.z(),
                                  length_.z() - lengthOffset_.z()));
}

Result<ToolPath> GcodeMachine::finish(const InputFile& file) {
  if (corner_) return invalid(missingAfterCorner(), file.atLine(corner_->line));
  if (nurbs_) return invalid("G5.2 is not ended, by G5.3", file.atLine(line_));
  if (auto ended = endCompensation(); !ended) {
    Error error = ended.error();
    error.where = file.atLine(line_);
    return error;
  }
  builder_.path.moves = moves_;
  builder_.path.dwell = dwell_;
  builder_.path.unknownMoves = leftOut_;
  auto& notices = builder_.path.notices;
  for (const auto& [line, sentence] : notes_) {
    notices.push_back(fmt::format("{}: {}", file.atLine(line).text(), sentence));
  }
  if (leftOut_ > 0) {
    notices.push_back(fmt::format(
        "{}: {} of the machine (G28, G30, G53) that are not known: the tool is out of the way "
        "until X, Y and Z are given again",
        file.atLine(firstLeftOut_).text(),
        model::counted(leftOut_, "move goes to places", "moves go to places")));
  }
  if (dwells_ > 0) {
    notices.push_back(fmt::format("{}: {} no time here", file.path.string(),
                                  model::counted(dwells_, "dwell takes", "dwells take")));
  }
  if (wholeNumbers_ > 0) {
    notices.push_back(fmt::format(
        "{}: {} without a point, which count thousandths of a millimetre or ten thousandths of "
        "an inch, as on Fanuc's controls; --dialect linuxcnc takes them as they are",
        file.atLine(firstWhole_).text(), model::counted(wholeNumbers_, "number", "numbers")));
  }
  return builder_.finish();
}

}  // namespace t4d::formats
