#include "t4d/measure/overlap.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "t4d/measure/solid_difference.h"
#include "t4d/slice/light_slice.h"
#include "t4d/slice/slice.h"

namespace t4d::measure {
namespace {

constexpr std::uint32_t kCoarse = 64;
constexpr std::uint32_t kFine = 256;

class Overlaps {
 public:
  Overlaps(const model::Source& a, const model::Source& b) : a_(a), b_(b), lightA_(a), lightB_(b) {}

  Result<SolidDifference> at(double time) const {
    const auto sliceA = a_.at(time);
    if (!sliceA) return sliceA.error();
    const auto sliceB = b_.at(time);
    if (!sliceB) return sliceB.error();
    return solidOverlap(sliceA->mesh, sliceB->mesh, {.resolution = kFine});
  }

  /// A volume to compare with those of other times: of light slices, which have a thirteenth of the
  /// triangles.
  Result<double> volumeAt(double time) const {
    const auto sliceA = lightA_.at(time);
    if (!sliceA) return sliceA.error();
    const auto sliceB = lightB_.at(time);
    if (!sliceB) return sliceB.error();
    const auto found =
        solidOverlap(sliceA->slice.mesh, sliceB->slice.mesh, {.resolution = kCoarse});
    if (!found) return found.error();
    return found->volume;
  }

  /// The volume of the smaller solid.
  Result<double> smallerVolumeAt(double time) const {
    const auto sliceA = a_.at(time);
    if (!sliceA) return sliceA.error();
    const auto sliceB = b_.at(time);
    if (!sliceB) return sliceB.error();
    return std::min(std::abs(signedVolume(sliceA->mesh)), std::abs(signedVolume(sliceB->mesh)));
  }

  Result<void> measure(ContactInterval& interval) const {
    if (!interval.overlaps && interval.end == interval.begin) return {};
    double best = interval.begin;
    double most = 0;
    const double step = (interval.end - interval.begin) / kOverlapSamples;
    const auto sample = [&](double time) -> Result<double> {
      const auto found = volumeAt(time);
      if (found && *found > most) {
        most = *found;
        best = time;
      }
      return found;
    };
    for (int k = 0; k <= kOverlapSamples; ++k) {
      const double time = k == kOverlapSamples ? interval.end : interval.begin + k * step;
      if (auto found = sample(time); !found) return found.error();
      if (!(step > 0)) break;
    }
    // Golden sections; where the overlap has several maxima, about one of them.
    constexpr int kSections = 12;
    constexpr double kPart = 1 / std::numbers::phi;
    double low = std::max(interval.begin, best - step);
    double high = std::min(interval.end, best + step);
    if (most > 0 && high > low) {
      double left = high - kPart * (high - low);
      double right = low + kPart * (high - low);
      Result<double> atLeft = sample(left);
      Result<double> atRight = sample(right);
      for (int k = 0; k < kSections && atLeft && atRight; ++k) {
        if (*atLeft < *atRight) {
          low = std::exchange(left, right);
          right = low + kPart * (high - low);
          atLeft = std::exchange(atRight, sample(right));
        } else {
          high = std::exchange(right, left);
          left = high - kPart * (high - low);
          atRight = std::exchange(atLeft, sample(left));
        }
      }
      if (!atLeft) return atLeft.error();
      if (!atRight) return atRight.error();
    }
    const auto found = at(best);
    if (!found) return found.error();
    interval.deepestTime = best;
    // Where no two cells cross, a part of one solid lies inside the other, or the solids only
    // touch, and rounding leaves a film.
    constexpr double kFilm = 1e-10;
    if (!interval.overlaps) {
      const auto smaller = smallerVolumeAt(best);
      if (!smaller) return smaller.error();
      if (found->volume <= kFilm * *smaller) {
        interval.deepestTime = interval.begin;
        return {};
      }
    }
    interval.overlaps = true;
    interval.overlapVolume = found->volume;
    interval.volumeError = found->error;
    return {};
  }

 private:
  slice::TimeSlicer a_;
  slice::TimeSlicer b_;
  slice::LightSlicer lightA_;
  slice::LightSlicer lightB_;
};

}  // namespace

Result<void> measureOverlaps(const model::Source& a, const model::Source& b,
                             std::span<ContactInterval> intervals) {
  if (intervals.empty()) return {};
  const Overlaps overlaps(a, b);
  for (ContactInterval& interval : intervals) {
    if (auto done = overlaps.measure(interval); !done) return done;
  }
  return {};
}

Result<std::vector<double>> overlapVolumes(const model::Source& a, const model::Source& b,
                                           std::span<const double> times) {
  const Overlaps overlaps(a, b);
  std::vector<double> volumes;
  for (const double time : times) {
    const auto found = overlaps.volumeAt(time);
    if (!found) return found.error();
    volumes.push_back(*found);
  }
  return volumes;
}

}  // namespace t4d::measure
