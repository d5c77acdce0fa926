#include "measure/overlap.h"

#include <algorithm>
#include <numbers>
#include <numeric>
#include <utility>

#include "measure/overlap_depth.h"
#include "t4d/check.h"
#include "t4d/mesh.h"
#include "t4d/slice.h"

namespace t4d::measure {
namespace {

constexpr std::uint32_t kCoarse = 64;
constexpr std::uint32_t kFine = 256;

class Overlaps {
 public:
  Overlaps(const model::Source& a, const model::Source& b)
      : sourceA_(&a), sourceB_(&b), a_(a), b_(b), lightA_(a), lightB_(b) {}

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

  /// Whether the interiors have common points then, beyond the rounding of coordinates.
  Result<bool> isDeepAt(double time) const {
    const auto sliceA = a_.at(time);
    if (!sliceA) return sliceA.error();
    const auto sliceB = b_.at(time);
    if (!sliceB) return sliceB.error();
    if (sliceA->mesh.triangles.empty() || sliceB->mesh.triangles.empty()) return false;
    return OverlapDepth(sliceA->mesh, sliceB->mesh).greatest(0, 0, /*any=*/true) > 0;
  }

  /// Times that are looked at first: evenly spaced ones, those in which cells cross, and layers,
  /// where motions change.
  std::vector<double> timesIn(const ContactInterval& interval) const {
    std::vector<double> times;
    const model::TimeSpan whole{interval.begin, interval.end};
    for (std::uint64_t k = 0; k <= kOverlapSamples; ++k) {
      times.push_back(model::dividedTime(whole, k, kOverlapSamples));
    }
    const auto& [begin, end] = interval.crossing;
    if (begin >= interval.begin && end <= interval.end) {
      times.insert(times.end(), {begin, std::midpoint(begin, end), end});
    }
    for (const model::Source* source : {sourceA_, sourceB_}) {
      std::vector<double> layers;
      for (std::size_t i = 0; i < source->slabCount(); ++i) {
        const double layer = source->timeSpan(i).end;
        if (layer > interval.begin && layer < interval.end) layers.push_back(layer);
      }
      const std::size_t every = (layers.size() + kOverlapSamples - 1) / kOverlapSamples;
      for (std::size_t i = 0; i < layers.size(); i += every) times.push_back(layers[i]);
    }
    std::ranges::sort(times);
    times.erase(std::ranges::unique(times).begin(), times.end());
    return times;
  }

  Result<void> measure(ContactInterval& interval) const {
    if (!interval.overlaps && interval.end == interval.begin) return {};
    const std::vector<double> times = timesIn(interval);
    double best = interval.begin;
    double most = 0;
    const auto sample = [&](double time) -> Result<double> {
      const auto found = volumeAt(time);
      if (found && *found > most) {
        most = *found;
        best = time;
      }
      return found;
    };
    for (const double time : times) {
      if (auto found = sample(time); !found) return found.error();
    }
    // Golden sections; where the overlap has several maxima, about one of them.
    constexpr int kSections = 12;
    constexpr double kPart = 1 / std::numbers::phi;
    const auto at = std::ranges::find(times, best);
    double low = at == times.begin() ? best : *(at - 1);
    double high = at + 1 == times.end() ? best : *(at + 1);
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
    if (!interval.overlaps) {
      // No two cells cross: a part of one solid lies inside the other, or the solids only touch.
      const auto isDeep = isDeepAt(best);
      if (!isDeep) return isDeep.error();
      if (!*isDeep) {
        interval.deepestTime = interval.begin;
        return {};
      }
    }
    const auto found = this->at(best);
    if (!found) return found.error();
    interval.overlaps = true;
    interval.deepestTime = best;
    interval.overlapVolume = found->volume;
    interval.volumeError = found->error;
    return {};
  }

 private:
  const model::Source* sourceA_;
  const model::Source* sourceB_;
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
