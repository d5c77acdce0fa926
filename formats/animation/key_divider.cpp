#include "formats/animation/key_divider.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "model/chords.h"

namespace t4d::formats {
namespace {

/// More keys of a body, an hour of 55 a second, would be an attack or a tolerance mistyped.
constexpr std::size_t kMostKeys = 200'000;

}  // namespace

/// How far slices are from their vertices in the worst of `count` steps of a span.
double KeyDivider::edgesOff(const model::TimeSpan& span, std::uint64_t count) {
  shape_.place(span.begin, false, from_);
  double worst = 0;
  for (std::uint64_t i = 1; i <= count; ++i) {
    shape_.place(model::dividedTime(span, i, count), i == count, to_);
    worst = std::max(worst, model::edgeDeviation(from_, to_, triangles_, limits_.edgeFactor));
    std::swap(from_, to_);
  }
  double reach = 0;
  for (const model::Point3& position : from_) {
    reach = std::max(reach, position.cwiseAbs().maxCoeff());
  }
  // A solid that only moves changes its edges by rounding.
  constexpr double kRounding = 16 * std::numeric_limits<double>::epsilon();
  return worst > kRounding * reach ? worst : 0;
}

/// Halves the span where its bound asks for many steps, since bounds of shorter spans are better.
Result<void> KeyDivider::divide(const model::TimeSpan& span, std::vector<double>& times) {
  constexpr double kManySteps = 8;
  const double duration = span.end - span.begin;
  const double tolerance = limits_.tolerance;
  const double acceleration = shape_.accelerationBound(span.begin, span.end);
  // Without a bound, products of infinities may be no number.
  double steps =
      std::isfinite(acceleration)
          ? std::max(1.0, std::ceil(duration * std::sqrt(acceleration / (8 * tolerance))))
          : std::numeric_limits<double>::infinity();
  while (steps <= kManySteps) {
    const double step = duration / steps;
    const double left = tolerance - step * step * acceleration / 8;
    const double edges = edgesOff(span, static_cast<std::uint64_t>(steps));
    if (edges <= left) break;
    // Changes of edges add up: this is the least number of steps, however the span is divided.
    if (edges > tolerance * static_cast<double>(kMostKeys)) return tooManyKeys();
    // What edges add shrinks with the step, more or less.
    const double more = left > 0 ? std::ceil(steps * edges / left) : 0;
    steps = std::max(steps + 1, std::min(more, kManySteps + 1));
  }
  const double middle = model::dividedTime(span, 1, 2);
  if (!(steps <= kManySteps)) {
    if (!(middle > span.begin && middle < span.end)) {
      return invalid(fmt::format("turns too fast at time {}: a rotation passes through zero, or "
                                 "the tolerance of {} is too small",
                                 span.begin, tolerance),
                     where_);
    }
    if (auto done = divide({span.begin, middle}, times); !done) return done;
    return divide({middle, span.end}, times);
  }
  const auto count = static_cast<std::uint64_t>(steps);
  for (std::uint64_t i = 1; i <= count; ++i) {
    const double time = model::dividedTime(span, i, count);
    if (time > times.back()) times.push_back(time);
  }
  keys_ += count;
  if (keys_ > kMostKeys) return tooManyKeys();
  return {};
}

double largestExtent(const MovingShape& shape, std::size_t vertexCount,
                     const model::TimeSpan& played) {
  double largest = 0;
  std::vector<model::Point3> positions(vertexCount);
  // A shape that is hidden at first has its size later.
  for (const double time : {played.begin, played.begin / 2 + played.end / 2, played.end}) {
    shape.place(time, false, positions);
    model::Bounds3 bounds;
    for (const model::Point3& position : positions) bounds.add(position);
    largest = std::max(largest, (bounds.max - bounds.min).maxCoeff());
  }
  return largest;
}

Result<std::vector<double>> tolerancesOf(const std::optional<double>& given,
                                         std::span<const double> extents, Place where) {
  constexpr double kUsual = 1e-3;
  constexpr double kLeast = 1e-9;
  double largest = 0;
  for (const double extent : extents) largest = std::max(largest, extent);
  std::vector<double> tolerances;
  bool valid = true;
  for (const double extent : extents) {
    const double tolerance = given.value_or(std::max(kUsual * extent, kLeast * largest));
    valid = valid && tolerance > 0 && std::isfinite(tolerance);
    tolerances.push_back(tolerance);
  }
  if (valid) return tolerances;
  return invalid(given ? fmt::format("the tolerance is {}; it must be a positive length", *given)
                       : "has no solid with a size at its first, middle and last time, from which "
                         "a tolerance could be taken; give one",
                 std::move(where));
}

Error KeyDivider::tooManyKeys() const {
  return invalid(fmt::format("needs more than {} keys for the tolerance of {}; allow a larger one",
                             kMostKeys, limits_.tolerance),
                 where_);
}

}  // namespace t4d::formats
