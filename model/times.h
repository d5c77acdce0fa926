#pragma once

#include <cstdint>
#include <optional>
#include <vector>

/// Times of layers, frames and slices, computed to equal the decimal numbers that people type.
///
/// A double means the shortest decimal number that reads back as it, for instance 0.7. Multiples
/// are computed exactly for these decimal numbers and rounded once: the third step of 0.7 from 0
/// ends at 2.1, while 3 * 0.7 in doubles is 2.0999999999999996. If the exact numbers need more than
/// 128 bits, plain double arithmetic is used.
namespace t4d::model {

class Source;

struct TimeSpan {
  double begin = 0;
  double end = 0;
};

/// begin + k * step.
double steppedTime(double begin, double step, std::uint64_t k);

/// begin + (end - begin) * k / n, with n > 0; begin for k = 0, end for k = n. k may exceed n.
double dividedTime(const TimeSpan& span, std::uint64_t k, std::uint64_t n);

/// The steppedTime of every k below `count`.
std::vector<double> steppedTimes(double begin, double step, std::uint64_t count);

/// `count` times evenly spaced from `begin` to `end`, both included; `begin` alone for one.
std::vector<double> evenTimes(const TimeSpan& span, std::uint64_t count);

/// Times within this distance are considered equal. In units in the last place of the largest
/// magnitude among the time and both ends of the mesh. Sums of rounded steps are off by one or two.
inline constexpr int kSameTimeUlps = 4;

/// The time of a mesh that `time` refers to: the nearest end or layer within kSameTimeUlps,
/// otherwise `time` itself; nothing if it is outside the mesh, or the mesh has no slab.
std::optional<double> timeWithin(const Source& source, double time);

/// The time that `time` refers to in a mesh that lasts for `span`: the nearest end within
/// kSameTimeUlps, otherwise `time` itself; nothing if it is outside the span.
std::optional<double> timeWithin(const TimeSpan& span, double time);

}  // namespace t4d::model
