#include "measure/clearance_over_time.h"

#include <algorithm>
#include <array>
#include <memory>

#include "measure/overlap_depth.h"
#include "model/progress.h"
#include "t4d/slice.h"

namespace t4d::measure {
namespace {

using model::Point3;

/// A solid that stays as it is from time 0 to 1: three tetrahedra over each triangle.
model::Mesh standing(const model::TriangleMesh& solid) {
  const auto count = static_cast<std::uint32_t>(solid.vertices.size());
  auto connectivity = std::make_shared<model::Connectivity>();
  connectivity->lowerCount = connectivity->upperCount = count;
  connectivity->vertexCount = 2 * count;
  model::Slab slab{0, 1, {}, nullptr, {}};
  for (const double time : {0.0, 1.0}) {
    for (const Point3& vertex : solid.vertices) {
      slab.vertices.emplace_back(vertex.x(), vertex.y(), vertex.z(), time);
    }
  }
  for (model::Triangle corners : solid.triangles) {
    // Sorted, so that prisms of neighbours fit; the order of corners keeps the orientation.
    const auto [p, q, r] = corners;
    const bool even = (p < q) == ((q < r) == (p < r));
    std::ranges::sort(corners);
    const auto [a, b, c] = corners;
    std::array<model::Cell, 3> cells = {model::Cell{a, b, c, c + count},
                                        model::Cell{a, b, b + count, c + count},
                                        model::Cell{a, a + count, b + count, c + count}};
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (even == (i == 1)) std::swap(cells[i][0], cells[i][1]);
      connectivity->cells.push_back(cells[i]);
    }
  }
  slab.connectivity = connectivity;
  model::Mesh mesh;
  (void)mesh.put(slab);
  return mesh;
}

/// Measures two slices, in contact or not.
Result<ClearanceSample> sampleOf(const slice::LightSlice& a, const slice::LightSlice& b,
                                 bool contact, double bound) {
  ClearanceSample sample;
  const model::TriangleMesh& meshA = a.slice.mesh;
  const model::TriangleMesh& meshB = b.slice.mesh;
  if (contact) {
    sample.overlapDepth = OverlapDepth(meshA, meshB).greatest();
    return sample;
  }
  const auto found = collide(standing(meshA), standing(meshB), {.overlapVolumes = false});
  if (!found) return found.error();
  if (const auto& nearest = found->clearance) {
    sample.distance = nearest->distance;
    sample.lowerBound = std::max(0.0, nearest->lowerBound - bound - a.distance - b.distance);
  }
  return sample;
}

}  // namespace

Result<std::vector<ClearanceSample>> clearanceOverTime(const model::Source& a,
                                                       const model::Source& b,
                                                       const Collision& collision,
                                                       const CollisionVerdict& verdict,
                                                       std::span<const double> times,
                                                       const model::Progress& progress) {
  std::vector<ClearanceSample> samples;
  const slice::LightSlicer slicerA(a);
  const slice::LightSlicer slicerB(b);
  for (std::size_t i = 0; i < times.size(); ++i) {
    const double time = times[i];
    if (model::timeWithin(a, time) && model::timeWithin(b, time)) {
      const auto meets = [&](const ContactInterval& interval) {
        return interval.begin <= time && time <= interval.end;
      };
      const auto sliceA = slicerA.at(time);
      if (!sliceA) return sliceA.error();
      const auto sliceB = slicerB.at(time);
      if (!sliceB) return sliceB.error();
      // One that is empty has no distance: in a gap between runs of slabs.
      if (!sliceA->slice.mesh.triangles.empty() && !sliceB->slice.mesh.triangles.empty()) {
        auto sample = sampleOf(*sliceA, *sliceB, std::ranges::any_of(collision.intervals, meets),
                               verdict.knownBound());
        if (!sample) return sample.error();
        sample->time = time;
        samples.push_back(*sample);
      }
    }
    if (auto on = model::report(progress, i + 1, times.size()); !on) return on.error();
  }
  return samples;
}

}  // namespace t4d::measure
