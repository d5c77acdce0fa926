#include "t4d/mill/motion_parts.h"

#include <algorithm>
#include <cmath>

namespace t4d::mill {
namespace {

/// The part of a segment between two fractions. The axis moves with the translation of the screw.
model::Segment between(const model::Segment& whole, double from, double to, double timeFrom,
                       double timeTo) {
  model::Segment part;
  part.timeBegin = timeFrom;
  part.timeEnd = timeTo;
  part.start = whole.at(from);
  part.end = whole.at(to);
  part.screw = whole.screw;
  part.screw.axisPoint += from * whole.screw.translation;
  part.screw.angleDegrees *= to - from;
  part.screw.translation *= to - from;
  return part;
}

/// How far the origin of the moving frame goes at most.
double travelOf(const model::Segment& segment) {
  const model::Point3 arm = segment.start.translation - segment.screw.axisPoint;
  const double radius = arm.cross(segment.screw.axisDirection).norm();
  constexpr double kRadians = 3.14159265358979323846 / 180;
  return segment.screw.translation.norm() +
         radius * kRadians * std::abs(segment.screw.angleDegrees);
}

}  // namespace

model::Motion partOf(const model::Motion& motion, const model::TimeSpan& span, double travel) {
  model::Motion part;
  for (const model::Segment& segment : motion.segments) {
    const double begin = std::max(span.begin, segment.timeBegin);
    const double end = std::min(span.end, segment.timeEnd);
    if (!(begin < end)) continue;
    const double duration = segment.timeEnd - segment.timeBegin;
    const auto fraction = [&](double time) {
      if (time == segment.timeEnd) return 1.0;
      return (time - segment.timeBegin) / duration;
    };
    const double way = travelOf(segment) * (fraction(end) - fraction(begin));
    const double pieces = std::max(1.0, std::ceil(way / travel));
    double from = begin;
    for (double i = 1; i <= pieces; ++i) {
      const double to = i == pieces ? end : begin + (end - begin) * (i / pieces);
      if (!(from < to)) continue;
      part.segments.push_back(between(segment, fraction(from), fraction(to), from, to));
      from = to;
    }
  }
  return part;
}

double timeAfterTravel(const model::Motion& motion, double time, double travel) {
  for (const model::Segment& segment : motion.segments) {
    if (segment.timeEnd <= time) continue;
    const double begin = std::max(time, segment.timeBegin);
    const double speed = travelOf(segment) / (segment.timeEnd - segment.timeBegin);
    const double way = speed * (segment.timeEnd - begin);
    if (way >= travel && speed > 0) return std::min(segment.timeEnd, begin + travel / speed);
    travel -= way;
  }
  return std::max(time, motion.timeEnd());
}

}  // namespace t4d::mill
