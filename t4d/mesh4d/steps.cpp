#include "t4d/mesh4d/steps.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

namespace t4d::mesh4d {
namespace {

constexpr double kDegreesPerRadian = 180.0 / std::numbers::pi;

/// The number of steps for an angle; a whole number up to the rounding of acos() is taken as exact.
double stepsFor(double angleDegrees, double stepDegrees) {
  constexpr double kRounding = 1e-12;
  return std::ceil(std::abs(angleDegrees) / stepDegrees * (1 - kRounding));
}

/// The largest distance of a point of the posed mesh from the segment's axis.
double radiusAbout(const model::Segment& segment, const std::vector<model::Point3>& points) {
  double largest = 0;
  for (const model::Point3& point : points) {
    const Eigen::Vector3d arm = segment.start(point) - segment.screw.axisPoint;
    largest = std::max(largest, arm.cross(segment.screw.axisDirection).norm());
  }
  return largest;
}

Result<void> checkRule(const StepRule& rule) {
  if (const auto* volume = std::get_if<MinVolumeRatio>(&rule)) {
    if (!(volume->ratio >= 0 && volume->ratio < 1)) {
      return invalid(
          fmt::format("R_Vmin is {}; it must lie in [0, 1), 0.998 for instance", volume->ratio));
    }
  } else if (const auto* steps = std::get_if<StepsPerSegment>(&rule)) {
    if (steps->steps == 0) return invalid("0 steps were requested; at least 1 is needed");
  } else if (!(std::get<MaxDeviation>(rule).length > 0)) {
    return invalid(fmt::format("the maximum deviation is {}; it must be a positive length",
                               std::get<MaxDeviation>(rule).length));
  }
  return {};
}

/// The largest angle of one step of `segment`, in degrees.
double stepDegrees(const StepRule& rule, const model::Segment& segment,
                   const std::vector<model::Point3>& points) {
  if (const auto* volume = std::get_if<MinVolumeRatio>(&rule)) {
    return std::acos(2 * volume->ratio - 1) * kDegreesPerRadian;
  }
  const double radius = radiusAbout(segment, points);
  const double sagitta = std::get<MaxDeviation>(rule).length;
  if (sagitta >= radius) return 180;
  // 1 - cos(angle / 2) = sagitta / radius, solved without cancellation at small angles.
  return 4 * std::asin(std::sqrt(sagitta / (2 * radius))) * kDegreesPerRadian;
}

}  // namespace

Result<std::vector<std::uint64_t>> stepsOf(const model::Motion& motion, const StepRule& rule,
                                           const std::vector<model::Point3>& points) {
  if (auto checked = checkRule(rule); !checked) return pass(checked.error());
  std::vector<std::uint64_t> counts;
  counts.reserve(motion.segments.size());
  double total = 0;
  for (const model::Segment& segment : motion.segments) {
    double steps = 1;
    if (const auto* fixed = std::get_if<StepsPerSegment>(&rule)) {
      steps = static_cast<double>(fixed->steps);
    } else if (segment.screw.angleDegrees != 0) {
      steps =
          std::max(1.0, stepsFor(segment.screw.angleDegrees, stepDegrees(rule, segment, points)));
    }
    total += steps;
    if (!(total <= static_cast<double>(kMaxSteps))) {
      return invalid(fmt::format("the motion needs {:.4g} steps or more, at most {} are possible; "
                                 "allow larger steps, or shorten the motion",
                                 total, kMaxSteps),
                     {}, Remedy::StepRule);
    }
    counts.push_back(static_cast<std::uint64_t>(steps));
  }
  return counts;
}

}  // namespace t4d::mesh4d
