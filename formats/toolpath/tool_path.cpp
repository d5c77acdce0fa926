#include "formats/toolpath/tool_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "model/degrees.h"
#include "model/limits.h"
#include "model/number.h"

namespace t4d::formats {
namespace {

// Rounding of directions in a text file.
constexpr double kNoTurnDegrees = 1e-9;

constexpr std::array<int, 12> kOffsets = {280, 300, 530, 540, 550, 560,
                                          570, 580, 590, 591, 592, 593};

/// 593 of "G59.3"; 0 of anything else.
int offsetOf(std::string_view word) {
  if (!word.starts_with('G') || word.size() < 3) return 0;
  const auto digits = model::numberIn<int>(word.substr(1, 2));
  if (!digits) return 0;
  int code = 10 * *digits;
  if (word.size() == 5 && word[3] == '.') code += word[4] - '0';
  const bool whole = word.size() == 3 || (word.size() == 5 && word[3] == '.');
  return whole && std::ranges::find(kOffsets, code) != kOffsets.end() ? code : 0;
}

}  // namespace

std::vector<platform::FileFormat> toolPathFormats() {
  constexpr std::string_view kByCaller = "what the caller says";
  return {{"G-code",
           {".nc", ".ngc", ".gcode", ".tap"},
           {"straight moves and chords of arcs", "rapid moves", "changes of tools", "times"},
           false,
           kByCaller},
          {"cutter locations (APT)",
           {".cl", ".cls", ".apt"},
           {"straight moves and turns", "rapid moves", "changes of tools", "times"},
           false,
           kByCaller},
          {"tool table of LinuxCNC", {".tbl"}, {"lengths of tools", "remarks"}, false, kByCaller}};
}

Result<model::Point3> parsePoint(std::string_view text) {
  const std::string_view whole = text;
  model::Point3 point;
  for (int axis = 0; axis < 3; ++axis) {
    const std::string_view number = text.substr(0, axis < 2 ? text.find(',') : text.npos);
    const auto value = model::numberIn<double>(number);
    if (!value || !(std::abs(*value) <= model::kLargestCoordinate)) {
      return invalid(fmt::format("found '{}', expected a point as in 100,0,-20", whole));
    }
    point[axis] = *value;
    text.remove_prefix(std::min(number.size() + 1, text.size()));
  }
  return point;
}

Result<void> parseOffset(std::string_view text, std::map<int, model::Point3>& offsets) {
  const auto equals = std::min(text.find('='), text.size());
  const int code = offsetOf(text.substr(0, equals));
  if (code == 0 || equals == text.size()) {
    return invalid(fmt::format(
        "'{}' is not an offset; expected G53 to G59.3, G28 or G30 and a point, as in G55=100,0,-20",
        text));
  }
  const auto point = parsePoint(text.substr(equals + 1));
  if (!point) return point.error();
  if (!offsets.emplace(code, *point).second) {
    return invalid(fmt::format("'{}' gives {} a second time", text, text.substr(0, equals)));
  }
  return {};
}

ToolPathBuilder::ToolPathBuilder(const ToolPathOptions& options) : options_(options) {
  if (!options.tools) tool_ = 0;
}

void ToolPathBuilder::start(const model::Point3& tip, const Eigen::Vector3d& axis) {
  started_ = true;
  tip_ = tip;
  axis_ = axis.stableNormalized();
  pose_.rotation =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), axis_).toRotationMatrix();
  pose_.translation = tip;
}

double ToolPathBuilder::turnTo(const Eigen::Vector3d& axis) const {
  const Eigen::Vector3d to = axis.stableNormalized();
  return model::kDegreesPerRadian * std::atan2(axis_.cross(to).norm(), axis_.dot(to));
}

Result<void> ToolPathBuilder::moveTo(const model::Point3& tip, const Eigen::Vector3d& axis,
                                     double seconds, bool rapid) {
  const double degrees = turnTo(axis);
  if (degrees >= model::kHalfTurnDegrees) {
    return invalid(
        "the tool turns by half a turn in one move, which could be any way round; give an axis "
        "between");
  }
  const bool turns = degrees > kNoTurnDegrees;
  if (!turns && (tip - tip_).norm() <= kNoWay) return {};
  if (!(tip.cwiseAbs().maxCoeff() <= model::kLargestCoordinate)) {
    return invalid(fmt::format("a coordinate exceeds {}", model::kLargestCoordinate));
  }
  std::vector<model::Segment>& segments = path.motion.segments;
  if (segments.size() >= model::kMaxSegments) {
    return fail(ErrorCode::Unsupported,
                fmt::format("the path has more than {} straight moves; allow chords of arcs a "
                            "larger tolerance, or divide the program",
                            model::kMaxSegments));
  }
  model::Segment segment;
  segment.timeBegin = time_;
  segment.timeEnd = time_ + seconds;
  if (!(segment.timeEnd > segment.timeBegin) || !(segment.timeEnd <= model::kLargestCoordinate)) {
    return invalid(fmt::format(
        "the move takes {:.3g} s, which cannot be represented at time {:.6g}", seconds, time_));
  }
  segment.start = pose_;
  segment.screw.axisPoint = tip_;
  segment.screw.translation = tip - tip_;
  if (turns) {
    segment.screw.angleDegrees = degrees;
    segment.screw.axisDirection = axis_.cross(axis.stableNormalized()).stableNormalized();
    axis_ = axis.stableNormalized();
    pose_.rotation = segment.screw.at(1).rotation * pose_.rotation;
  }
  pose_.translation = tip;
  tip_ = tip;
  segment.end = pose_;
  time_ = segment.timeEnd;
  segments.push_back(segment);
  if (!rapid) return {};
  if (!path.rapids.empty() && path.rapids.back().end == segment.timeBegin) {
    path.rapids.back().end = segment.timeEnd;
  } else {
    path.rapids.push_back({segment.timeBegin, segment.timeEnd});
  }
  return {};
}

Result<void> ToolPathBuilder::mount(std::optional<int> tool) {
  if (!options_.tools) return {};
  if (tool && std::ranges::find(*options_.tools, *tool) == options_.tools->end()) {
    return invalid(fmt::format("tool {} is mounted, but not given (tools: {})", *tool,
                               fmt::join(*options_.tools, ", ")),
                   {}, Remedy::EachTool);
  }
  tool_ = tool;
  if (!away_) hold(tool);
  return {};
}

void ToolPathBuilder::hold(std::optional<int> tool) {
  auto& mountings = path.mountings;
  if (!mountings.empty() && mountings.back().time == time_) mountings.pop_back();
  mountings.push_back({time_, tool});
}

void ToolPathBuilder::leave() {
  if (away_) return;
  away_ = true;
  if (path.mountings.empty() && tool_ && time_ > 0) path.mountings.push_back({0, tool_});
  hold(std::nullopt);
}

Result<void> ToolPathBuilder::comeBack(const model::Point3& tip, const Eigen::Vector3d& axis) {
  const auto rapid = [&](const Eigen::Vector3d& to) {
    const double seconds =
        std::max(60 * (tip - tip_).norm() / options_.rapidFeed, turnTo(to) / kTurnDegreesPerSecond);
    return moveTo(tip, to, seconds, true);
  };
  if (turnTo(axis) >= model::kHalfTurnDegrees) {
    if (auto moved = rapid(axis_.unitOrthogonal()); !moved) return moved;
  }
  if (auto moved = rapid(axis); !moved) return moved;
  away_ = false;
  hold(tool_);
  return {};
}

Result<ToolPath> ToolPathBuilder::finish() {
  if (path.motion.segments.empty()) {
    return invalid("nothing moves: there are no two different positions of the tool");
  }
  path.motion.lengthUnit = "mm";
  path.motion.timeUnit = "s";
  return std::move(path);
}

}  // namespace t4d::formats
