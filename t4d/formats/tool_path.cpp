#include "t4d/formats/tool_path.h"

#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "t4d/model/limits.h"

namespace t4d::formats {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

// Rounding of directions in a text file.
constexpr double kNoTurnDegrees = 1e-9;

}  // namespace

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
  return kDegrees * std::atan2(axis_.cross(to).norm(), axis_.dot(to));
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
  if (!turns && tip == tip_) return {};
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

Result<ToolPath> ToolPathBuilder::finish() {
  if (path.motion.segments.empty()) {
    return invalid("nothing moves: there are no two different positions of the tool");
  }
  path.motion.lengthUnit = "mm";
  path.motion.timeUnit = "s";
  return std::move(path);
}

}  // namespace t4d::formats
