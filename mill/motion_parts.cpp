#include "mill/motion_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace t4d::mill {
namespace {

using model::Point3;

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
  const Point3 arm = segment.start.translation - segment.screw.axisPoint;
  const double radius = arm.cross(segment.screw.axisDirection).norm();
  constexpr double kRadians = 3.14159265358979323846 / 180;
  return segment.screw.translation.norm() +
         radius * kRadians * std::abs(segment.screw.angleDegrees);
}

/// The first segment that ends after a time.
std::vector<model::Segment>::const_iterator segmentAfter(const model::Motion& motion, double time) {
  return std::ranges::partition_point(
      motion.segments, [&](const model::Segment& segment) { return segment.timeEnd <= time; });
}

/// Takes the parts of one span of a motion.
class Parts {
 public:
  Parts(double travel, double reach, const Near& near,
        const std::function<Result<void>(const model::Motion&)>& take)
      : travel_(travel), reach_(reach), near_(near), take_(take) {}

  Result<void> add(const model::Segment& segment, const model::TimeSpan& span) {
    segment_ = &segment;
    begin_ = std::max(span.begin, segment.timeBegin);
    end_ = std::min(span.end, segment.timeEnd);
    if (!(begin_ < end_)) return {};
    way_ = travelOf(segment) * (fraction(end_) - fraction(begin_));
    count_ = std::max(1.0, std::ceil(way_ / travel_));
    // How far the frame goes while a time is rounded.
    constexpr double kUlps = 4 * std::numeric_limits<double>::epsilon();
    rounding_ = kUlps * std::max(std::abs(segment.timeBegin), std::abs(segment.timeEnd)) *
                travelOf(segment) / (segment.timeEnd - segment.timeBegin);
    return addPieces(0, count_);
  }

  Result<void> finish() {
    if (run_.segments.empty()) return {};
    model::Motion run;
    std::swap(run, run_);
    return take_(run);
  }

 private:
  double timeAt(double piece) const {
    return piece == count_ ? end_ : begin_ + (end_ - begin_) * (piece / count_);
  }
  double fraction(double time) const {
    if (time == segment_->timeEnd) return 1;
    return (time - segment_->timeBegin) / (segment_->timeEnd - segment_->timeBegin);
  }

  /// Those from `first` to before `last`: halves them, until they are one or too far away.
  Result<void> addPieces(double first, double last) {
    if (++looks_ > kMostLooks) {
      return fail(
          ErrorCode::Unsupported,
          fmt::format("the tool goes round the stock or past it for too long: it was looked "
                      "for in {} pieces of {:g}; is it in the length units of the stock?",
                      kMostLooks, travel_),
          {}, Remedy::Motion);
    }
    const double from = timeAt(first);
    const double to = timeAt(last);
    if (!(from < to)) return {};
    const double middle = std::floor((first + last) / 2);
    const Point3 center = segment_->at(fraction(timeAt(middle))).translation;
    // This is the way from the middle to either end, with what rounding adds.
    constexpr double kRounding = 1e-12;
    const double farthest = (last - middle) / count_ * way_;
    const double rounding = rounding_ + kRounding * (center.cwiseAbs().maxCoeff() + way_ + reach_);
    if (!near_(center, reach_ + farthest + rounding)) return finish();
    if (middle > first && middle < last) {
      if (auto done = addPieces(first, middle); !done) return done;
      return addPieces(middle, last);
    }
    run_.segments.push_back(between(*segment_, fraction(from), fraction(to), from, to));
    return run_.segments.size() < kMostParts ? Result<void>() : finish();
  }

  double travel_;
  double reach_;
  const Near& near_;
  const std::function<Result<void>(const model::Motion&)>& take_;
  const model::Segment* segment_ = nullptr;
  double begin_ = 0;
  double end_ = 0;
  double way_ = 0;
  double count_ = 1;     // of pieces
  double rounding_ = 0;  // of places, by that of times
  std::uint64_t looks_ = 0;
  model::Motion run_;
};

}  // namespace

Result<void> visitParts(const model::Motion& motion, const model::TimeSpan& span, double travel,
                        double reach, const Near& near,
                        const std::function<Result<void>(const model::Motion&)>& take) {
  Parts parts(travel, reach, near, take);
  for (auto segment = segmentAfter(motion, span.begin);
       segment != motion.segments.end() && segment->timeBegin < span.end; ++segment) {
    if (auto done = parts.add(*segment, span); !done) return done;
  }
  return parts.finish();
}

double timeAfterTravel(const model::Motion& motion, double time, double travel) {
  for (auto segment = segmentAfter(motion, time); segment != motion.segments.end(); ++segment) {
    const double begin = std::max(time, segment->timeBegin);
    const double speed = travelOf(*segment) / (segment->timeEnd - segment->timeBegin);
    const double way = speed * (segment->timeEnd - begin);
    if (way >= travel && speed > 0) return std::min(segment->timeEnd, begin + travel / speed);
    travel -= way;
  }
  return std::max(time, motion.timeEnd());
}

}  // namespace t4d::mill
