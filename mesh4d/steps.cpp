#include "mesh4d/steps.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "model/degrees.h"

namespace t4d::mesh4d {
namespace {

/// The number of steps for an angle; a whole number up to the rounding of acos() is taken as exact.
double stepsFor(double angleDegrees, double stepDegrees) {
  constexpr double kRounding = 1e-12;
  return std::ceil(std::abs(angleDegrees) / stepDegrees * (1 - kRounding));
}

/// The steps of a segment that turns.
double stepsFor(const StepRule& rule, double angleDegrees, const model::Chords& chords) {
  if (const auto* volume = std::get_if<MinVolumeRatio>(&rule)) {
    return stepsFor(angleDegrees, std::acos(2 * volume->ratio - 1) * model::kDegreesPerRadian);
  }
  const double allowed = std::get<MaxDeviation>(rule).length;
  const double steps = stepsFor(angleDegrees, chords.angleFor(allowed) * model::kDegreesPerRadian);
  // The angle is rounded, too.
  const bool more = chords.forAngle(angleDegrees / steps / model::kDegreesPerRadian) > allowed;
  return more ? steps + 1 : steps;
}

/// A deviation that so many steps can keep, rounded up to two digits; nothing if there is none.
std::optional<double> possibleDeviation(const model::Motion& motion,
                                        std::span<const model::Chords> chords, std::uint64_t most) {
  double degrees = 0;
  for (const model::Segment& segment : motion.segments) {
    degrees += std::abs(segment.screw.angleDegrees);
  }
  // Each segment may have two steps more, by rounding up.
  const double left = static_cast<double>(most) - 2 * static_cast<double>(motion.segments.size());
  const double radians = degrees / model::kDegreesPerRadian / left;
  if (!(left > 0 && radians <= std::numbers::pi)) return std::nullopt;
  double deviation = 0;
  for (const model::Chords& one : chords) deviation = std::max(deviation, one.forAngle(radians));
  const double digit = std::pow(10, std::floor(std::log10(deviation)) - 1);
  return (std::floor(deviation / digit) + 1) * digit;
}

}  // namespace

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

std::vector<model::Chords> chordsOf(const model::Motion& motion, const model::TriangleMesh& mesh,
                                    PrismSplit split) {
  std::vector<Eigen::Vector3d> edges;
  std::vector<model::Chords> all(motion.segments.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    const model::Segment& segment = motion.segments[i];
    if (segment.screw.angleDegrees == 0) continue;
    if (edges.empty()) {
      for (const model::Triangle& triangle : mesh.triangles) {
        for (int k = 0; k < 3; ++k) {
          // Each edge of a closed mesh is in two triangles, in opposite directions.
          const std::uint32_t from = triangle[k];
          const std::uint32_t to = triangle[(k + 1) % 3];
          if (from < to) edges.emplace_back(mesh.vertices[to] - mesh.vertices[from]);
        }
      }
    }
    // The axis and a point of it in the coordinates of the mesh.
    const Eigen::Vector3d axis = segment.start.rotation.transpose() * segment.screw.axisDirection;
    const model::Point3 center =
        segment.start.rotation.transpose() * (segment.screw.axisPoint - segment.start.translation);
    double radius = 0;
    for (const model::Point3& vertex : mesh.vertices) {
      radius = std::max(radius, axis.cross(vertex - center).squaredNorm());
    }
    double edge = 0;
    for (const Eigen::Vector3d& one : edges) edge = std::max(edge, axis.cross(one).squaredNorm());
    all[i] = {std::sqrt(radius), std::sqrt(edge),
              split == PrismSplit::Fourteen ? model::kEdgeFactorOf14 : model::kEdgeFactorOf3};
  }
  return all;
}

Result<std::vector<std::uint64_t>> stepsOf(const model::Motion& motion, const StepRule& rule,
                                           std::span<const model::Chords> chords,
                                           std::uint64_t most) {
  if (auto checked = checkRule(rule); !checked) return checked.error();
  std::vector<std::uint64_t> counts;
  counts.reserve(motion.segments.size());
  double total = 0;
  for (std::size_t i = 0; i < motion.segments.size(); ++i) {
    const double degrees = motion.segments[i].screw.angleDegrees;
    double steps = 1;
    if (const auto* fixed = std::get_if<StepsPerSegment>(&rule)) {
      steps = static_cast<double>(fixed->steps);
    } else if (degrees != 0) {
      const model::Chords here = i < chords.size() ? chords[i] : model::Chords{};
      steps = std::max(1.0, stepsFor(rule, degrees, here));
    }
    total += steps;
    if (!(total <= static_cast<double>(most))) {
      const auto possible = std::holds_alternative<MaxDeviation>(rule)
                                ? possibleDeviation(motion, chords, most)
                                : std::nullopt;
      return invalid(
          fmt::format("the motion needs {:.4g} steps or more, at most {} are possible; {}", total,
                      most,
                      possible ? fmt::format("a deviation of {:.2g} is possible", *possible)
                               : "allow larger steps, or shorten the motion"),
          {}, Remedy::StepRule);
    }
    counts.push_back(static_cast<std::uint64_t>(steps));
  }
  return counts;
}

double largestDeviation(const model::Motion& motion, std::span<const std::uint64_t> steps,
                        std::span<const model::Chords> chords) {
  double largest = 0;
  for (std::size_t i = 0; i < chords.size(); ++i) {
    const double degrees = motion.segments[i].screw.angleDegrees / static_cast<double>(steps[i]);
    largest = std::max(largest, chords[i].forAngle(degrees / model::kDegreesPerRadian));
  }
  return largest;
}

}  // namespace t4d::mesh4d
