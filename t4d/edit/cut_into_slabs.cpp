#include "t4d/edit/cut_into_slabs.h"

#include <algorithm>

#include "t4d/edit/split_cells.h"

namespace t4d::edit {
namespace {

using formats::Mesh4d;
using model::Cell;
using model::Point4;

/// A slab of fewer cells costs more than it saves.
constexpr std::uint64_t kFewestCells = 256;

std::vector<double> distinctTimes(const std::vector<Point4>& vertices) {
  std::vector<double> times;
  times.reserve(vertices.size());
  // -0 and 0 are one time.
  for (const Point4& vertex : vertices) times.push_back(vertex[3] + 0.0);
  std::ranges::sort(times);
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

std::size_t indexOf(const std::vector<double>& times, double time) {
  return static_cast<std::size_t>(std::ranges::lower_bound(times, time) - times.begin());
}

/// The times, other than the first and the last, that no cell reaches over, such that the slabs
/// between them have at least kFewestCells.
std::vector<double> freeCuts(const Mesh4d& mesh, const std::vector<double>& times) {
  std::vector<std::int64_t> over(times.size() + 1);  // difference of the cells that reach over
  std::vector<std::uint64_t> ending(times.size());   // cells whose last time it is
  std::vector<std::uint32_t> timeOf(mesh.vertices.size());
  for (std::size_t i = 0; i < timeOf.size(); ++i) {
    timeOf[i] = static_cast<std::uint32_t>(indexOf(times, mesh.vertices[i][3]));
  }
  for (const Cell& cell : mesh.cells) {
    const auto [first, last] =
        std::minmax({timeOf[cell[0]], timeOf[cell[1]], timeOf[cell[2]], timeOf[cell[3]]});
    ++ending[last];
    if (last <= first + 1) continue;
    ++over[first + 1];
    --over[last];
  }
  std::vector<double> cuts;
  std::int64_t reaching = 0;
  std::uint64_t cells = 0;
  std::uint64_t left = mesh.cells.size();
  for (std::size_t i = 0; i + 1 < times.size(); ++i) {
    reaching += over[i];
    cells += ending[i];
    left -= ending[i];
    if (i == 0 || reaching > 0 || cells < kFewestCells || left < kFewestCells) continue;
    cuts.push_back(times[i]);
    cells = 0;
  }
  return cuts;
}

/// `count` - 1 times of vertices between the first and the last, such that about as many cells lie
/// between them.
std::vector<double> evenCuts(const Mesh4d& mesh, const std::vector<double>& times,
                             std::uint64_t count) {
  if (times.size() < 3 || count < 2) return {};
  if (count >= times.size() - 1) return {times.begin() + 1, times.end() - 1};
  std::vector<double> middles;
  middles.reserve(mesh.cells.size());
  for (const Cell& cell : mesh.cells) {
    const auto [begin, end] = timesOf(mesh.vertices, cell);
    middles.push_back(begin + (end - begin) / 2);
  }
  std::ranges::sort(middles);
  std::vector<double> cuts;
  for (std::uint64_t i = 1; i < count; ++i) {
    const double wanted = middles[middles.size() * i / count];
    // At least one time is left for each of the cuts to come, as one was for each before.
    const std::size_t least = cuts.empty() ? 1 : indexOf(times, cuts.back()) + 1;
    const std::size_t most = times.size() - 1 - (count - i);
    std::size_t at = indexOf(times, wanted);
    if (at > 0 && at < times.size() && wanted - times[at - 1] < times[at] - wanted) --at;
    cuts.push_back(times[std::clamp(at, least, most)]);
  }
  return cuts;
}

/// The slabs of a mesh whose cells no cut splits any more, sorted by slab.
Result<model::Mesh> assembled(const std::vector<Point4>& vertices,
                              std::vector<std::vector<Cell>> cells,
                              const std::vector<double>& bounds) {
  constexpr std::uint32_t kUnused = ~std::uint32_t{0};
  const std::size_t count = cells.size();
  // The layer between two slabs: the vertices at its time that either of them has.
  std::vector<std::vector<std::uint32_t>> inside(count);
  std::vector<std::vector<std::uint32_t>> layers(count + 1);
  std::vector<std::uint32_t> seenIn(vertices.size(), kUnused);
  for (std::uint32_t slab = 0; slab < count; ++slab) {
    for (const Cell& cell : cells[slab]) {
      for (const std::uint32_t corner : cell) {
        if (seenIn[corner] == slab) continue;
        const double t = vertices[corner][3];
        const bool isShared = seenIn[corner] != kUnused;
        seenIn[corner] = slab;
        if (slab > 0 && t == bounds[slab]) {
          if (!isShared) layers[slab].push_back(corner);
        } else if (slab + 1 < count && t == bounds[slab + 1]) {
          layers[slab + 1].push_back(corner);
        } else {
          inside[slab].push_back(corner);
        }
      }
    }
  }
  for (auto& layer : layers) std::ranges::sort(layer);
  model::Mesh mesh;
  std::vector<std::uint32_t> number(vertices.size());
  for (std::size_t i = 0; i < count; ++i) {
    std::ranges::sort(inside[i]);
    auto connectivity = std::make_shared<model::Connectivity>();
    model::Slab slab;
    slab.timeBegin = bounds[i];
    slab.timeEnd = bounds[i + 1];
    for (const auto* some : {&layers[i], &inside[i], &layers[i + 1]}) {
      for (const std::uint32_t vertex : *some) {
        number[vertex] = static_cast<std::uint32_t>(slab.vertices.size());
        slab.vertices.push_back(vertices[vertex]);
      }
    }
    connectivity->vertexCount = static_cast<std::uint32_t>(slab.vertices.size());
    connectivity->lowerCount = static_cast<std::uint32_t>(layers[i].size());
    connectivity->upperCount = static_cast<std::uint32_t>(layers[i + 1].size());
    connectivity->cells = std::move(cells[i]);
    for (Cell& cell : connectivity->cells) {
      for (std::uint32_t& corner : cell) corner = number[corner];
    }
    slab.connectivity = std::move(connectivity);
    if (auto put = mesh.put(slab); !put) return pass(put.error());
  }
  return mesh;
}

Result<model::Mesh> oneSlab(Mesh4d mesh, const std::vector<double>& times) {
  auto connectivity = std::make_shared<model::Connectivity>();
  connectivity->vertexCount = static_cast<std::uint32_t>(mesh.vertices.size());
  connectivity->cells = std::move(mesh.cells);
  model::Mesh slabs;
  auto put = slabs.put({times.front(), times.back(), std::move(mesh.vertices), connectivity, {}});
  if (!put) return pass(put.error());
  return slabs;
}

}  // namespace

Result<CutMesh> cutIntoSlabs(Mesh4d mesh, const SlabCuts& cuts) {
  if (mesh.vertices.empty()) return invalid("has no vertices");
  const std::vector<double> times = distinctTimes(mesh.vertices);
  const std::vector<double> at =
      cuts.slabs ? evenCuts(mesh, times, *cuts.slabs) : freeCuts(mesh, times);
  CutMesh result;
  if (at.empty()) {
    auto whole = oneSlab(std::move(mesh), times);
    if (!whole) return pass(whole.error());
    result.mesh = std::move(*whole);
    return result;
  }
  const auto isSplit = [&](const Cell& cell) {
    const auto [begin, end] = timesOf(mesh.vertices, cell);
    const auto next = std::ranges::upper_bound(at, begin);
    return next != at.end() && end > *next;
  };
  if (auto good = checkNoTwins(mesh.cells, isSplit); !good) return pass(good.error());
  std::vector<std::vector<Cell>> cells(at.size() + 1);
  CellSplitter splitter(mesh.vertices);
  std::vector<Cell> parts;
  std::vector<Cell> after;
  for (const Cell& cell : mesh.cells) {
    const auto [begin, end] = timesOf(mesh.vertices, cell);
    // The slab in which the cell begins; a cell at one time belongs to the slab before.
    auto slab = static_cast<std::size_t>(
        (begin == end ? std::ranges::lower_bound(at, begin) : std::ranges::upper_bound(at, begin)) -
        at.begin());
    if (slab == at.size() || end <= at[slab]) {
      cells[slab].push_back(cell);
      continue;
    }
    ++result.splitTetrahedra;
    parts = {cell};
    for (; slab < at.size() && !parts.empty(); ++slab) {
      after.clear();
      for (const Cell& part : parts) {
        if (timesOf(mesh.vertices, part).end <= at[slab]) {
          cells[slab].push_back(part);
        } else if (timesOf(mesh.vertices, part).begin >= at[slab]) {
          after.push_back(part);
        } else {
          splitter.split(part, at[slab], cells[slab], after);
        }
      }
      parts = after;
    }
    cells[slab].insert(cells[slab].end(), parts.begin(), parts.end());
  }
  result.newVertices = splitter.cutEdges().size();
  std::vector<double> bounds = {times.front()};
  bounds.insert(bounds.end(), at.begin(), at.end());
  bounds.push_back(times.back());
  auto slabs = assembled(mesh.vertices, std::move(cells), bounds);
  if (!slabs) return pass(slabs.error());
  result.mesh = std::move(*slabs);
  return result;
}

}  // namespace t4d::edit
