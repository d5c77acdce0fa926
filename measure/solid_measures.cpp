#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <numeric>

#include <fmt/format.h>

#include "measure/surface_genus.h"
#include "model/parallel.h"
#include "model/progress.h"
#include "t4d/check.h"
#include "t4d/mesh.h"
#include "t4d/slice.h"

namespace t4d::measure {

using model::Point3;

void SolidMeasures::add(const SolidMeasures& other) {
  const double both = volume + other.volume;
  if (both != 0) {
    centroid = (volume * centroid + other.volume * other.centroid) / both;
  } else if (!other.bounds.empty()) {
    centroid = other.centroid;
  }
  volume = both;
  area += other.area;
  components += other.components;
  cavities += other.cavities;
  genus += other.genus;
  bounds.add(other.bounds);
}

SolidMeasures measuresOf(const model::TriangleMesh& mesh) {
  SolidMeasures made;
  if (mesh.triangles.empty()) return made;
  made.volume = signedVolume(mesh);
  made.area = surfaceArea(mesh);
  for (const model::Triangle& triangle : mesh.triangles) {
    for (const std::uint32_t vertex : triangle) made.bounds.add(mesh.vertices[vertex]);
  }
  for (const ConnectedSurface& surface : surfacesOf(mesh)) {
    made.genus += surface.genus;
    ++(surface.volume < 0 ? made.cavities : made.components);
  }
  // The moment is about the middle, so that little is lost far from the origin.
  const Point3 middle = (made.bounds.min + made.bounds.max) / 2;
  Point3 moment = Point3::Zero();
  for (const auto& [i, j, k] : mesh.triangles) {
    const Point3 a = mesh.vertices[i] - middle;
    const Point3 b = mesh.vertices[j] - middle;
    const Point3 c = mesh.vertices[k] - middle;
    moment += a.dot(b.cross(c)) / 24 * (a + b + c);
  }
  // A solid that has just vanished is flat, and its volume nothing but rounding.
  constexpr double kRounding = 1e-13;
  const double extent = (made.bounds.max - made.bounds.min).norm();
  const bool isFlat = std::abs(made.volume) <= kRounding * made.area * extent;
  made.centroid = isFlat ? middle : Point3(middle + moment / made.volume);
  return made;
}

Result<std::vector<std::vector<SolidMeasures>>> measuresOfEach(std::span<const model::Body> bodies,
                                                               std::span<const double> times,
                                                               const model::Progress& progress) {
  const model::TimeSpan span = model::timeSpanOf(bodies);
  for (const double time : times) {
    if (model::timeWithin(span, time)) continue;
    return invalid(fmt::format("time {} is outside the mesh, which lasts from {} to {}", time,
                               span.begin, span.end));
  }
  // Runs of times that follow one another, so that most slabs are read once.
  std::vector<std::size_t> order(times.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return times[i]; });
  constexpr std::size_t kRun = 8;
  const std::size_t runs = (times.size() + kRun - 1) / kRun;
  std::vector<std::vector<SolidMeasures>> measures(bodies.size());
  for (auto& ofBody : measures) {
    ofBody.resize(times.size());
    for (std::size_t i = 0; i < times.size(); ++i) ofBody[i].time = times[i];
  }
  std::vector<Result<void>> outcomes(runs);
  std::size_t done = 0;
  std::atomic<bool> ended = false;
  std::mutex reporting;
  model::forEachTask(runs, [&](std::size_t run) {
    if (ended) return;
    const auto own =
        std::span(order).subspan(run * kRun, std::min(kRun, order.size() - run * kRun));
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      const model::Source& source = *bodies[b].source;
      std::vector<std::size_t> there;
      std::vector<double> at;
      for (const std::size_t i : own) {
        if (!model::timeWithin(source, times[i])) continue;
        there.push_back(i);
        at.push_back(times[i]);
      }
      const auto slices = slice::sliceAtTimes(source, at);
      for (std::size_t k = 0; k < there.size(); ++k) {
        if (!slices[k]) {
          outcomes[run] = slices[k].error();
          return;
        }
        if (!isClosed(slices[k]->mesh)) {
          outcomes[run] =
              invalid(fmt::format("the slice at time {} is not closed, so that it has no volume",
                                  times[there[k]]),
                      placeIn({}, fmt::format("body '{}'", bodies[b].name)));
          return;
        }
        measures[b][there[k]].add(measuresOf(slices[k]->mesh));
      }
    }
    const std::scoped_lock lock(reporting);
    done += own.size();
    outcomes[run] = model::report(progress, done, times.size());
    if (!outcomes[run]) ended = true;
  });
  for (const Result<void>& outcome : outcomes) {
    if (!outcome) return outcome.error();
  }
  return measures;
}

std::vector<SolidMeasures> addedUp(std::span<const std::vector<SolidMeasures>> bodies) {
  std::vector<SolidMeasures> sums(bodies.empty() ? 0 : bodies.front().size());
  for (std::size_t i = 0; i < sums.size(); ++i) {
    sums[i].time = bodies.front()[i].time;
    for (const auto& body : bodies) sums[i].add(body[i]);
  }
  return sums;
}

Result<std::vector<SolidMeasures>> measuresAt(std::span<const model::Body> bodies,
                                              std::span<const double> times,
                                              const model::Progress& progress) {
  const auto each = measuresOfEach(bodies, times, progress);
  if (!each) return each.error();
  return addedUp(*each);
}

}  // namespace t4d::measure
