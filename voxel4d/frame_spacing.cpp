#include "voxel4d/frame_spacing.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include <fmt/format.h>

#include "model/amount_text.h"
#include "model/degrees.h"
#include "model/limits.h"
#include "t4d/mesh.h"

namespace t4d::voxel4d {
namespace {

/// A step that misses the last time by less than this fraction of its length reaches it.
constexpr double kStepTolerance = 1e-9;

using Eigen::Vector3d;

/// A screw in the frame of the unmoved mesh: its points stay, and the world moves the other way.
///
/// At the fraction f of a segment the point p moves, per segment, by
///
///   d/df (R(f) (s(p) - a) + f T) = theta d x R(f) (s(p) - a) + T
///
/// with s the segment's start, a and d its axis, theta its angle, T its translation. Rotated back
/// by R(f), and with T = T_across + T_along, this has the length of
///
///   u + R(-f) T_across + T_along,    u = theta d x (s(p) - a),
///
/// where u and R(-f) T_across are perpendicular to the axis and T_along is parallel to it. The
/// first is fixed and the second describes an arc of angle theta, so the length is largest where
/// the arc comes nearest to the direction of u. The length is a convex function of p, so its
/// maximum over a mesh is at a vertex.
class SeenScrew {
 public:
  explicit SeenScrew(const model::Segment& segment)
      : angle_(std::abs(segment.screw.angleDegrees) * model::kRadiansPerDegree) {
    const model::Screw& screw = segment.screw;
    const double sign = screw.angleDegrees < 0 ? -1 : 1;
    const Eigen::Matrix3d back = segment.start.rotation.transpose();
    axisPoint_ = back * (screw.axisPoint - segment.start.translation);
    axis_ = sign * (back * screw.axisDirection);
    const Vector3d translation = back * screw.translation;
    along_ = std::abs(axis_.dot(translation));
    const Vector3d across = translation - axis_.dot(translation) * axis_;
    across_ = across.norm();
    if (across_ > 0) acrossDirection_ = across / across_;
  }

  /// The maximum over all points within `reach` of `centre`; an upper bound.
  double pathWithin(const model::Point3& centre, double reach) const {
    const double radius = axis_.cross(centre - axisPoint_).norm() + reach;
    return std::hypot(angle_ * radius + across_, along_);
  }

  /// The maximum speed of `point` times the segment's duration.
  double pathOf(const model::Point3& point) const {
    const Vector3d u = angle_ * axis_.cross(point - axisPoint_);
    if (across_ == 0) return std::hypot(u.norm(), along_);
    const double length = u.norm();
    const double x = u.dot(acrossDirection_);
    const double y = u.dot(axis_.cross(acrossDirection_));
    // R(-f) T_across is |T_across| (cos phi, -sin phi) here, with phi from 0 to theta.
    double nearest = std::atan2(-y, x);
    if (nearest < 0) nearest += 2 * std::numbers::pi;
    const double cosine =
        nearest <= angle_ ? length : std::max(x, x * std::cos(angle_) - y * std::sin(angle_));
    const double square = length * length + across_ * across_ + 2 * across_ * cosine;
    return std::hypot(std::sqrt(std::max(square, 0.0)), along_);
  }

 private:
  double angle_;  // radians, not negative
  Vector3d axisPoint_;
  Vector3d axis_;  // of length 1; the rotation is right-handed about it
  double along_ = 0;
  double across_ = 0;
  Vector3d acrossDirection_ = Vector3d::Zero();
};

Result<void> checkCount(double count) {
  if (count <= static_cast<double>(kMaxFrames)) return {};
  return invalid(fmt::format("{:.0f} frames; at most {} are allowed", count, kMaxFrames));
}

/// The number of frames at intervals of `when.step`: as many as fit, or `when.count`.
Result<std::uint64_t> countOfSteps(const model::TimeSpan& span, const FrameTimes& when) {
  const double step = *when.step;
  if (!(step > 0) || !std::isfinite(step)) {
    return invalid(
        fmt::format("the time between frames is {}; it must be a positive number", step));
  }
  const double steps = std::floor((span.end - span.begin) / step + kStepTolerance);
  if (auto checked = checkCount(steps + 1); !checked) return checked.error();
  if (!(steps >= 1)) {
    return invalid(fmt::format("the time between frames is {}, but from {} to {} there is only {}",
                               step, span.begin, span.end, span.end - span.begin));
  }
  const auto fitting = static_cast<std::uint64_t>(steps) + 1;
  const std::uint64_t count = when.count.value_or(fitting);
  if (count < 2 || count > fitting) {
    return invalid(
        fmt::format("{} frames are requested, {} apart; from {} to {} there can be 2 to {}", count,
                    step, span.begin, span.end, fitting));
  }
  return count;
}

}  // namespace

Result<std::vector<double>> frameTimes(const model::TimeSpan& span, const FrameTimes& when) {
  std::vector<double> times;
  if (when.step) {
    auto count = countOfSteps(span, when);
    if (!count) return count.error();
    times = model::steppedTimes(span.begin, *when.step, *count);
    times.back() = std::min(times.back(), span.end);
  } else {
    const std::uint64_t count = when.count.value_or(0);
    if (count < 2) return invalid(fmt::format("{} frames; a series needs two or more", count));
    if (auto checked = checkCount(static_cast<double>(count)); !checked) {
      return checked.error();
    }
    times = model::evenTimes(span, count);
  }
  if (!std::is_sorted(times.begin(), times.end(), std::less_equal<>())) {
    return invalid(fmt::format("{} frames from time {} to {} are too close to be told apart",
                               times.size(), span.begin, times.back()));
  }
  return times;
}

Result<void> checkFrameTimes(std::span<const double> times, std::size_t frames) {
  if (times.size() != frames) {
    return invalid(fmt::format("{} for {}: expected one for each",
                               model::counted(times.size(), "time"),
                               model::counted(frames, "frame")));
  }
  for (std::size_t i = 0; i < frames; ++i) {
    if (!(std::abs(times[i]) <= model::kLargestCoordinate)) {
      return invalid(fmt::format("the time of frame {} is {}; at most {} is possible", i, times[i],
                                 model::kLargestCoordinate));
    }
    if (i == 0 || times[i] > times[i - 1]) continue;
    return invalid(fmt::format("times do not increase: frame {} is at {}, the one before at {}", i,
                               times[i], times[i - 1]));
  }
  return {};
}

double maxSpeed(const model::TriangleMesh& mesh, const model::Motion& motion) {
  if (mesh.vertices.empty()) return 0;
  const model::Bounds3 bounds = boundsOf(mesh);
  const model::Point3 centre = 0.5 * (bounds.min + bounds.max);
  double reach = 0;
  for (const model::Point3& vertex : mesh.vertices) {
    reach = std::max(reach, (vertex - centre).norm());
  }
  double fastest = 0;
  for (const model::Segment& segment : motion.segments) {
    const double duration = segment.timeEnd - segment.timeBegin;
    const SeenScrew screw(segment);
    if (screw.pathWithin(centre, reach) <= fastest * duration) continue;
    double longest = 0;
    for (const model::Point3& vertex : mesh.vertices) {
      longest = std::max(longest, screw.pathOf(vertex));
    }
    fastest = std::max(fastest, longest / duration);
  }
  return fastest;
}

double largestGap(std::span<const double> times) {
  double gap = 0;
  for (std::size_t i = 1; i < times.size(); ++i) gap = std::max(gap, times[i] - times[i - 1]);
  return gap;
}

Result<std::uint64_t> framesWithin(double distance, double speed, const model::TimeSpan& span) {
  // A path of a whole number of distances may come out longer by rounding.
  constexpr double kRounding = 1e-12;
  const double steps =
      std::max(1.0, std::ceil((span.end - span.begin) * speed / distance * (1 - kRounding)));
  if (!(steps < static_cast<double>(kMaxFrames))) {
    return invalid(
        fmt::format("no point moves by more than {} between two frames if there are "
                    "{:.4g} or more of them; at most {} are allowed",
                    distance, steps + 1, kMaxFrames));
  }
  return static_cast<std::uint64_t>(steps) + 1;
}

}  // namespace t4d::voxel4d
