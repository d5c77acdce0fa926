#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "formats/toolpath/gcode_machine.h"

/// Paths of a GcodeMachine that are not the programmed one: beside it by the radius of the cutter
/// (G41, G42), and with corners that are rounded (,R) or cut off (,C).
namespace t4d::formats {

Result<void> GcodeMachine::setCompensation(Tenths code, const GcodeBlock& block) {
  if (code == 400) return endCompensation();
  const std::string word = gcodeWord(code);
  if (compensation_) return invalid(word + ": the cutter is compensated already; give G40 before");
  if (modes_.plane[0] == 1) return invalid(word + " stands in the plane of Y and Z (G19)");
  double diameter = 0;
  if (code % 10 != 0) {
    if (!block.d) return invalid(word + " has no D, the diameter of the cutter");
    diameter = *block.d * modes_.unit;
  } else {
    const double number = block.d.value_or(mounted_.value_or(0));
    auto found = options_.diameters.find(static_cast<int>(number));
    if (!options_.tools && found == options_.diameters.end()) found = options_.diameters.find(0);
    if (found != options_.diameters.end()) {
      diameter = found->second;
    } else if (number != 0) {
      return invalid(fmt::format("{} D{:g}: there is no tool {:g}, whose diameter D names", word,
                                 number, number),
                     {}, Remedy::EachTool);
    }
  }
  if (diameter == 0) return {};
  if (!builder_.started()) {
    if (auto begun = beginAtStart(); !begun) return begun;
  }
  const bool left = (code < 420) == (diameter > 0);
  compensation_.emplace(modes_.plane, left, std::abs(diameter) / 2, tool_,
                        [this](const CompensatedMove& move) { return goCompensated(move); });
  return {};
}

/// A move of the centre of the cutter. at_ stays where the program is.
Result<void> GcodeMachine::goCompensated(const CompensatedMove& move) {
  const MachineAxes programmed = at_;
  const auto w = static_cast<std::size_t>(modes_.plane[2]);
  const double length = move.arc
                            ? std::hypot(move.arc->length(), move.to[w] - tool_[w]) * scaleInPlane()
                            : lengthBetween(tool_, move.to);
  const double seconds = 60 * length / move.feed;
  auto done = move.arc ? goAlong(*move.arc, move.to, seconds, move.rapid)
                       : go(move.to, seconds, move.rapid);
  at_ = programmed;
  return done;
}

Result<void> GcodeMachine::endCompensation() {
  if (!compensation_) return {};
  auto ended = compensation_->end();
  compensation_.reset();
  return ended;
}

std::string GcodeMachine::missingAfterCorner() const {
  return fmt::format("{} in line {} has no straight move after it", corner_->chamfer ? ",C" : ",R",
                     corner_->line);
}

/// A straight move whose end is a corner, or that comes after one.
Result<void> GcodeMachine::turnCorner(const GcodeBlock& block, const MachineAxes& to) {
  MachineAxes from = at_;
  if (corner_) {
    const Corner corner = *corner_;
    corner_.reset();
    const auto rounded = roundCorner(corner, to);
    if (!rounded) return rounded;
    from = corner.at;
  }
  if (!block.corner && !block.chamfer) return straight(to, false);
  const double size = block.corner.value_or(block.chamfer.value_or(0)) * modes_.unit;
  if (!(size >= 0)) return invalid(fmt::format("a corner has the size {:g}", size));
  corner_ = Corner{
      .from = from, .at = to, .size = size, .chamfer = block.chamfer.has_value(), .line = line_};
  at_ = to;
  return {};
}

Result<void> GcodeMachine::roundCorner(const Corner& corner, const MachineAxes& to) {
  using Eigen::Vector2d;
  const auto u = static_cast<std::size_t>(modes_.plane[0]);
  const auto v = static_cast<std::size_t>(modes_.plane[1]);
  const auto flat = [&](const MachineAxes& at) { return Vector2d(at[u], at[v]); };
  const Vector2d centre = flat(corner.at);
  const Vector2d before = centre - flat(corner.from);
  const Vector2d after = flat(to) - centre;
  const double turn =
      std::atan2(before.x() * after.y() - before.y() * after.x(), before.dot(after));
  const double half = std::tan(std::abs(turn) / 2);
  const double cut = corner.chamfer ? corner.size : corner.size * half;
  constexpr double kRounding = 1e-6;
  if (!(cut <= before.norm() + kRounding && cut <= after.norm() + kRounding)) {
    return invalid(
        fmt::format("the corner of line {} takes {:.6g} mm of its moves, which are "
                    "{:.6g} and {:.6g} mm long",
                    corner.line, cut, before.norm(), after.norm()));
  }
  const auto placed = [&](const Vector2d& point) {
    MachineAxes at = corner.at;
    at[u] = point.x();
    at[v] = point.y();
    return at;
  };
  at_ = corner.from;
  if (!(cut > 0)) return straight(corner.at, false);
  const MachineAxes begin = placed(centre - cut * before.normalized());
  const MachineAxes end = placed(centre + cut * after.normalized());
  if (auto done = straight(begin, false); !done) return done;
  if (corner.chamfer) return straight(end, false);
  const double side = turn > 0 ? 1 : -1;
  const Vector2d normal(-before.y(), before.x());
  ArcWords words{.from = flat(begin), .to = flat(end), .clockwise = turn < 0};
  words.centre = words.from + side * corner.size * normal.normalized();
  const auto arc = arcOf(words);
  if (!arc) return arc.error();
  if (!compensation_) {
    return goAlong(*arc, end, 60 * scaleInPlane() * arc->length() / feedOf(), false);
  }
  auto done = compensation_->arc(words, end, feedOf());
  at_ = end;
  return done;
}

}  // namespace t4d::formats
