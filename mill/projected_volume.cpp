#include "mill/projected_volume.h"

#include <algorithm>
#include <span>
#include <vector>

#include "model/parallel.h"

namespace t4d::mill {
namespace {

// Cells that are summed together, so that the sum is the same for any number of threads.
constexpr std::uint64_t kTogether = 1U << 15U;

void add(ProjectedVolume& sum, std::span<const model::Cell> cells,
         std::span<const model::Point4> vertices) {
  for (const auto& [a, b, c, d] : cells) {
    const model::Point3 p = vertices[a].head<3>();
    const double six = (vertices[b].head<3>() - p)
                           .dot((vertices[c].head<3>() - p).cross(vertices[d].head<3>() - p));
    // An exit is negatively oriented in space.
    (six < 0 ? sum.exits : sum.entries) += std::abs(six) / 6;
  }
}

template <class CellsOf>
ProjectedVolume sumOf(const model::TimeSpan& time, std::uint64_t count,
                      std::span<const model::Point4> vertices, const CellsOf& cellsOf) {
  const std::uint64_t groups = (count + kTogether - 1) / kTogether;
  std::vector<ProjectedVolume> parts(groups);
  model::forEach(groups, [&](std::uint64_t group) {
    const std::uint64_t first = group * kTogether;
    cellsOf(first, std::min(kTogether, count - first),
            [&](std::span<const model::Cell> cells) { add(parts[group], cells, vertices); });
  });
  ProjectedVolume sum{time};
  for (const ProjectedVolume& part : parts) {
    sum.exits += part.exits;
    sum.entries += part.entries;
  }
  return sum;
}

}  // namespace

Result<void> ProjectedVolumes::put(const model::Slab& slab) {
  const std::span<const model::Cell> cells = slab.connectivity->cells;
  take_(sumOf({slab.timeBegin, slab.timeEnd}, cells.size(), slab.vertices,
              [&](std::uint64_t first, std::uint64_t count, const auto& use) {
                use(cells.subspan(first, count));
              }));
  return next_.put(slab);
}

Result<void> ProjectedVolumes::putStreamed(const model::StreamedSlab& slab) {
  std::vector<model::Point4> vertices(slab.vertexCount);
  model::forEach((vertices.size() + kTogether - 1) / kTogether, [&](std::uint64_t group) {
    const std::uint64_t first = group * kTogether;
    slab.vertices(static_cast<std::uint32_t>(first),
                  std::span(vertices).subspan(first, std::min(kTogether, vertices.size() - first)));
  });
  take_(sumOf(slab.time, slab.cellCount, vertices,
              [&](std::uint64_t first, std::uint64_t count, const auto& use) {
                std::vector<model::Cell> cells(count);
                slab.cells(first, cells);
                use(cells);
              }));
  return next_.putStreamed(slab);
}

}  // namespace t4d::mill
