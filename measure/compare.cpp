#include <algorithm>
#include <memory>
#include <optional>

#include "model/parallel.h"
#include "model/progress.h"
#include "t4d/check.h"
#include "t4d/slice.h"

namespace t4d::measure {

Result<model::TriangleMesh> solidAt(std::span<const model::Body> bodies, double time) {
  model::TriangleMesh solid;
  for (const model::Body& body : bodies) {
    if (!model::timeWithin(*body.source, time)) continue;
    auto slice = slice::sliceAtTime(*body.source, time);
    if (!slice) return slice.error();
    const auto first = static_cast<std::uint32_t>(solid.vertices.size());
    solid.vertices.insert(solid.vertices.end(), slice->mesh.vertices.begin(),
                          slice->mesh.vertices.end());
    for (const auto& [a, b, c] : slice->mesh.triangles) {
      solid.triangles.push_back({first + a, first + b, first + c});
    }
  }
  return solid;
}

Result<SliceComparison> compareSolids(double time, const model::TriangleMesh& a,
                                      const model::TriangleMesh& b, const CompareOptions& options) {
  auto difference = solidDifference(a, b, options.difference);
  if (!difference) return difference.error();
  SliceComparison comparison;
  comparison.time = time;
  comparison.volumeA = signedVolume(a);
  comparison.volumeB = signedVolume(b);
  comparison.areaA = surfaceArea(a);
  comparison.areaB = surfaceArea(b);
  comparison.difference = *difference;
  comparison.distance = surfaceDistance(a, b, options.distanceTolerance);
  return comparison;
}

Result<std::vector<SliceComparison>> compareAt(std::span<const model::Body> a,
                                               std::span<const model::Body> b,
                                               std::span<const double> times,
                                               const CompareOptions& options,
                                               const model::Progress& progress) {
  const auto at = [&](std::size_t i) -> Result<SliceComparison> {
    auto solidOfA = solidAt(a, times[i]);
    if (!solidOfA) return solidOfA.error();
    auto solidOfB = solidAt(b, times[i]);
    if (!solidOfB) return solidOfB.error();
    return compareSolids(times[i], *solidOfA, *solidOfB, options);
  };
  using Item = std::shared_ptr<const Result<SliceComparison>>;
  std::vector<SliceComparison> comparisons;
  std::optional<Error> error;
  model::inOrder<Item>(
      times.size(),
      [&](std::size_t i) { return std::make_shared<const Result<SliceComparison>>(at(i)); },
      [&](const Item& comparison) {
        if (!*comparison) {
          error = comparison->error();
          return false;
        }
        comparisons.push_back(**comparison);
        const auto on = model::report(progress, comparisons.size(), times.size());
        if (!on) error = on.error();
        return on.has_value();
      });
  if (error) return *error;
  return comparisons;
}

std::vector<double> timesAmidSteps(std::span<const model::Body> bodies, const model::TimeSpan& span,
                                   std::uint64_t count) {
  std::vector<double> times = model::evenTimes(span, count);
  if (count < 3) return times;
  const double apart = (span.end - span.begin) / static_cast<double>(count - 1);
  std::vector<model::TimeSpan> steps(times.size());  // of each time, the longest
  for (const model::Body& body : bodies) {
    std::size_t next = 1;
    for (std::size_t i = 0; i < body.source->slabCount(); ++i) {
      const model::TimeSpan step = body.source->timeSpan(i);
      while (next + 1 < times.size() && times[next] < step.begin) ++next;
      for (; next + 1 < times.size() && times[next] < step.end; ++next) {
        model::TimeSpan& longest = steps[next];
        if (step.end - step.begin > longest.end - longest.begin) longest = step;
      }
    }
  }
  // This many times within a step show what happens in it. Rounding may make a step shorter.
  constexpr double kTimesThatShowAStep = 4 * (1 - 1e-9);
  for (std::size_t i = 1; i + 1 < times.size(); ++i) {
    const double length = steps[i].end - steps[i].begin;
    if (length > 0 && length < kTimesThatShowAStep * apart) {
      times[i] = model::dividedTime(steps[i], 1, 2);
    }
  }
  std::ranges::sort(times);
  times.erase(std::ranges::unique(times).begin(), times.end());
  return times;
}

std::size_t timesOnLayers(std::span<const model::Body> bodies, std::span<const double> times) {
  std::vector<std::vector<double>> layers;  // per body, in increasing order
  for (const model::Body& body : bodies) {
    std::vector<double>& own = layers.emplace_back();
    for (std::size_t i = 0; i < body.source->slabCount(); ++i) {
      const model::TimeSpan span = body.source->timeSpan(i);
      own.push_back(span.begin);
      own.push_back(span.end);
    }
  }
  std::size_t count = 0;
  for (const double time : times) {
    bool exists = false;
    bool onLayers = true;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const auto at = model::timeWithin(*bodies[i].source, time);
      if (!at) continue;
      exists = true;
      onLayers = onLayers && std::binary_search(layers[i].begin(), layers[i].end(), *at);
    }
    if (exists && onLayers) ++count;
  }
  return count;
}

}  // namespace t4d::measure
