#include "model/mechanism.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "model/degrees.h"
#include "model/limits.h"

namespace t4d::model {
namespace {

/// The segment that moves within a span; null where the motion has not begun or has ended.
const Segment* segmentIn(const Motion& motion, const TimeSpan& span) {
  const double middle = span.begin / 2 + span.end / 2;
  if (middle < motion.timeBegin() || middle > motion.timeEnd()) return nullptr;
  const auto after =
      std::upper_bound(motion.segments.begin(), motion.segments.end(), middle,
                       [](double t, const Segment& segment) { return t < segment.timeEnd; });
  return after == motion.segments.end() ? nullptr : &*after;
}

Screw screwOf(const Joint& joint, double value) {
  Screw screw;
  screw.axisPoint = joint.origin;
  screw.axisDirection = joint.axis;
  if (joint.type == Joint::Type::Prismatic) {
    screw.translation = value * joint.axis;
  } else {
    screw.angleDegrees = value;
    constexpr double kDegreesPerTurn = 360;
    screw.translation = value / kDegreesPerTurn * joint.pitch * joint.axis;
  }
  return screw;
}

}  // namespace

Pose Mechanism::at(std::size_t link, double time) const {
  Pose pose;
  for (std::size_t i = link; i != Link::kWorld; i = links[i].parent) {
    if (links[i].motion) pose = links[i].motion->at(time) * pose;
  }
  return pose;
}

bool Mechanism::moves(std::size_t link) const {
  for (std::size_t i = link; i != Link::kWorld; i = links[i].parent) {
    if (links[i].motion) return true;
  }
  return false;
}

std::optional<TimeSpan> Mechanism::span() const {
  std::optional<TimeSpan> all;
  for (const Link& link : links) {
    if (!link.motion) continue;
    const TimeSpan one{link.motion->timeBegin(), link.motion->timeEnd()};
    all = all ? TimeSpan{std::min(all->begin, one.begin), std::max(all->end, one.end)} : one;
  }
  return all;
}

std::vector<double> Mechanism::knots(std::size_t link) const {
  std::set<double> times;
  for (std::size_t i = link; i != Link::kWorld; i = links[i].parent) {
    if (!links[i].motion) continue;
    times.insert(links[i].motion->timeBegin());
    for (const Segment& segment : links[i].motion->segments) times.insert(segment.timeEnd);
  }
  return {times.begin(), times.end()};
}

Result<Motion> jointMotion(const Joint& joint, std::span<const double> times,
                           std::span<const double> values) {
  if (values.size() < 2 || values.size() > kMaxSegments) {
    return invalid(
        fmt::format("has {} values; a joint that moves has 2 to {}", values.size(), kMaxSegments));
  }
  Motion motion;
  motion.segments.reserve(values.size() - 1);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto where = [&] { return placeIn({}, fmt::format("value {} (counted from 0)", i)); };
    if (!(std::abs(values[i]) <= kLargestCoordinate)) {
      return invalid(
          fmt::format("is {}; the largest possible is {}", values[i], kLargestCoordinate), where());
    }
    if (!(std::abs(times[i]) <= kLargestCoordinate)) {
      return invalid(
          fmt::format("is at time {}; the largest possible is {}", times[i], kLargestCoordinate),
          where());
    }
    if (i == 0) continue;
    if (!(times[i] > times[i - 1])) {
      return invalid(fmt::format("is at time {}, not after the one before it, at {}: times must "
                                 "increase",
                                 times[i], times[i - 1]),
                     where());
    }
    motion.segments.push_back({times[i - 1], times[i], screwOf(joint, values[i - 1]).at(1),
                               screwOf(joint, values[i]).at(1),
                               screwOf(joint, values[i] - values[i - 1])});
  }
  return motion;
}

// For a point y(t) that a screw with the rates w and s about the axis (c, u) moves on to
// z = R(t) (y - c) + c + s t:
//   |z'|  <= |y'| + |w| r + |s|,   |z''| <= |y''| + 2 |w| |y'| + w^2 r,
// where r bounds the distance of y from the axis: that at the middle of the span, and what y can
// move until its ends.
double accelerationBound(const Mechanism& mechanism, std::size_t link, const Point3& place,
                         const TimeSpan& span) {
  const double middle = span.begin / 2 + span.end / 2;
  const double half = (span.end - span.begin) / 2;
  Point3 point = place;
  double speed = 0;
  double acceleration = 0;
  for (std::size_t i = link; i != Link::kWorld; i = mechanism.links[i].parent) {
    if (!mechanism.links[i].motion) continue;
    const Motion& motion = *mechanism.links[i].motion;
    if (const Segment* segment = segmentIn(motion, span)) {
      const double duration = segment->timeEnd - segment->timeBegin;
      const double rate = std::abs(segment->screw.angleDegrees) * kRadiansPerDegree / duration;
      const Point3 started = segment->start(point);
      const double radius =
          segment->screw.axisDirection.cross(started - segment->screw.axisPoint).norm() +
          speed * half;
      acceleration += 2 * rate * speed + rate * rate * radius;
      speed += rate * radius + segment->screw.translation.norm() / duration;
    }
    point = motion.at(middle)(point);
  }
  return acceleration;
}

double turnBound(const Mechanism& mechanism, std::size_t link, const TimeSpan& span) {
  double degrees = 0;
  for (std::size_t i = link; i != Link::kWorld; i = mechanism.links[i].parent) {
    if (!mechanism.links[i].motion) continue;
    const Segment* segment = segmentIn(*mechanism.links[i].motion, span);
    if (segment == nullptr) continue;
    degrees += std::abs(segment->screw.angleDegrees) * (span.end - span.begin) /
               (segment->timeEnd - segment->timeBegin);
  }
  return degrees;
}

}  // namespace t4d::model
