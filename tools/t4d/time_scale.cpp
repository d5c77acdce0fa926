#include "tools/t4d/time_scale.h"

#include <fmt/format.h>

#include "t4d/check.h"

namespace t4d::tools {
namespace {

/// The length of the diagonal of the mesh in space; 0 if it is empty.
Result<double> sizeOf(const Input& input) {
  const auto bounds = boundsOf(input);
  if (!bounds) return bounds.error();
  return bounds->empty() ? 0.0 : (bounds->max - bounds->min).norm();
}

/// Fails if cells would be flat up to rounding with this scale.
Result<void> checkScale(double scale, double size, const model::TimeSpan& span) {
  constexpr double kLongest = 1e12;  // of length to size; beyond it, rounding errors decide
  if (!(span.end > span.begin && size > 0)) return {};
  const double even = size / (span.end - span.begin);
  const double ratio = scale / even;
  if (ratio >= 1 / kLongest && ratio <= kLongest) return {};
  return fail(ErrorCode::Options,
              fmt::format("with a time scale of {} the mesh would be {:.3g} long in time and "
                          "{:.3g} wide in space, and volumes would {}; choose a scale from {:.2g} "
                          "to {:.2g}",
                          scale, scale * (span.end - span.begin), size,
                          ratio < 1 ? "vanish" : "overflow", even / kLongest, even * kLongest));
}

}  // namespace

Result<TimeScale> timeScaleOf(const std::optional<double>& given, const Input& input,
                              Observer& observer) {
  const model::TimeSpan span = model::timeSpanOf(input.bodies);
  if (given) {
    const auto size = sizeOf(input);
    if (!size) return size.error();
    if (auto fits = checkScale(*given, *size, span); !fits) return fits.error();
    return TimeScale{*given, "as given"};
  }
  const auto stage = observer.stage("measuring the speed", slabCountOf(input.bodies), "slabs");
  const auto speed = measure::meanNormalSpeed(input.bodies, stage->callback());
  if (!speed) return speed.error();
  if (*speed > 0) return TimeScale{*speed, "the mean normal speed"};
  const auto size = sizeOf(input);
  if (!size) return size.error();
  if (!(span.end > span.begin && *size > 0)) return TimeScale{1, "nothing moves or lasts"};
  return TimeScale{*size / (span.end - span.begin),
                   "nothing moves; the size divided by the duration"};
}

}  // namespace t4d::tools
