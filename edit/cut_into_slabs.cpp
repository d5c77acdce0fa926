#include <algorithm>

#include "edit/split_cells.h"
#include "model/attribute_rows.h"
#include "t4d/edit.h"
#include "t4d/file.h"
#include "t4d/mesh.h"

namespace t4d::edit {
namespace {

using formats::Mesh4d;
using model::Cell;
using model::Point4;

/// A slab of fewer cells costs more than it saves.
constexpr std::uint64_t kFewestCells = 256;

std::vector<double> distinctTimes(const std::vector<Point4>& vertices) {
  std::vector<double> times;
  for (const Point4& vertex : vertices) {
    // -0 and 0 are one time. Many vertices have that of the one before.
    const double time = vertex[3] + 0.0;
    if (times.empty() || times.back() != time) times.push_back(time);
  }
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
    const double time = mesh.vertices[i][3];
    timeOf[i] = i > 0 && time == mesh.vertices[i - 1][3]
                    ? timeOf[i - 1]
                    : static_cast<std::uint32_t>(indexOf(times, time));
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

/// The positions of cells among the cuts.
class CellPlaces {
 public:
  CellPlaces(const std::vector<Point4>& vertices, const std::vector<double>& cuts)
      : places_(vertices.size()) {
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const double time = vertices[i][3];
      if (i > 0 && time == vertices[i - 1][3]) {
        places_[i] = places_[i - 1];
        continue;
      }
      const auto [first, last] = std::ranges::equal_range(cuts, time);
      places_[i] = {static_cast<std::uint32_t>(first - cuts.begin()),
                    static_cast<std::uint32_t>(last - cuts.begin())};
    }
  }

  /// Whether a cut lies between its first time and its last, which are not on it.
  bool isSplit(const Cell& cell) const { return cutsBelow(cell) > cutsUpTo(cell); }
  /// The slab of a cell that is not split; one at the time of a cut belongs to the slab before.
  std::uint32_t slabOf(const Cell& cell) const { return std::min(cutsUpTo(cell), cutsBelow(cell)); }

 private:
  struct Place {
    std::uint32_t below;  // cuts before the vertex
    std::uint32_t upTo;   // and those at its time
  };
  std::uint32_t cutsUpTo(const Cell& cell) const {
    return std::min({places_[cell[0]].upTo, places_[cell[1]].upTo, places_[cell[2]].upTo,
                     places_[cell[3]].upTo});
  }
  std::uint32_t cutsBelow(const Cell& cell) const {
    return std::max({places_[cell[0]].below, places_[cell[1]].below, places_[cell[2]].below,
                     places_[cell[3]].below});
  }

  std::vector<Place> places_;
};

/// The slabs of a mesh whose cells no cut splits any more, sorted by slab.
/// `cellsOf` are the cells of `mesh` that they were, in each slab, if it has attributes.
Result<model::Mesh> assembled(const Mesh4d& mesh, std::vector<std::vector<Cell>> cells,
                              const std::vector<std::vector<std::uint32_t>>& cellsOf,
                              const std::vector<double>& bounds) {
  const std::vector<Point4>& vertices = mesh.vertices;
  const std::size_t count = cells.size();
  // The layer between two slabs: the vertices at its time that either of them has.
  std::vector<std::vector<std::uint32_t>> inside(count);
  std::vector<std::vector<std::uint32_t>> layers(count + 1);
  std::vector<std::uint32_t> seenIn(vertices.size(), model::kNoIndex);
  for (std::uint32_t slab = 0; slab < count; ++slab) {
    for (const Cell& cell : cells[slab]) {
      for (const std::uint32_t corner : cell) {
        if (seenIn[corner] == slab) continue;
        const double t = vertices[corner][3];
        const bool isShared = seenIn[corner] != model::kNoIndex;
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
  model::Mesh made;
  std::vector<std::uint32_t> number(vertices.size());
  std::vector<std::uint32_t> chosen;
  for (std::size_t i = 0; i < count; ++i) {
    std::ranges::sort(inside[i]);
    auto connectivity = std::make_shared<model::Connectivity>();
    model::Slab slab;
    slab.timeBegin = bounds[i];
    slab.timeEnd = bounds[i + 1];
    chosen.clear();
    for (const auto* some : {&layers[i], &inside[i], &layers[i + 1]}) {
      chosen.insert(chosen.end(), some->begin(), some->end());
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
    for (const model::Attribute& attribute : mesh.attributes) {
      const bool ofCells = attribute.domain == model::Domain::Cell;
      slab.attributes.push_back(rowsOf(attribute, ofCells ? cellsOf[i] : chosen));
    }
    if (auto put = made.put(slab); !put) return put.error();
  }
  return made;
}

Result<model::Mesh> oneSlab(Mesh4d mesh, const std::vector<double>& times) {
  auto connectivity = std::make_shared<model::Connectivity>();
  connectivity->vertexCount = static_cast<std::uint32_t>(mesh.vertices.size());
  connectivity->cells = std::move(mesh.cells);
  model::Mesh slabs;
  auto put = slabs.put({times.front(), times.back(), std::move(mesh.vertices), connectivity,
                        std::move(mesh.attributes)});
  if (!put) return put.error();
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
    if (!whole) return whole.error();
    result.mesh = std::move(*whole);
    return result;
  }
  const CellPlaces places(mesh.vertices, at);
  std::vector<std::size_t> counts(at.size() + 1);
  for (const Cell& cell : mesh.cells) {
    if (places.isSplit(cell)) {
      ++result.splitTetrahedra;
    } else {
      ++counts[places.slabOf(cell)];
    }
  }
  if (result.splitTetrahedra > 0) {
    const auto isSplit = [&](const Cell& cell) { return places.isSplit(cell); };
    if (auto good = checkNoTwins(mesh.cells, isSplit); !good) return good.error();
  }
  std::vector<std::vector<Cell>> cells(at.size() + 1);
  for (std::size_t i = 0; i < cells.size(); ++i) cells[i].reserve(counts[i]);
  CellSplitter splitter(mesh.vertices);
  std::vector<Cell> parts;
  std::vector<Cell> after;
  std::vector<std::vector<std::uint32_t>> cellsOf(cells.size());
  const auto noteCell = [&](std::size_t slab, std::size_t cell) {
    if (mesh.attributes.empty()) return;
    cellsOf[slab].resize(cells[slab].size(), static_cast<std::uint32_t>(cell));
  };
  for (std::size_t i = 0; i < mesh.cells.size(); ++i) {
    const Cell& cell = mesh.cells[i];
    std::size_t slab = places.slabOf(cell);
    if (!places.isSplit(cell)) {
      cells[slab].push_back(cell);
      noteCell(slab, i);
      continue;
    }
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
      noteCell(slab, i);
    }
    cells[slab].insert(cells[slab].end(), parts.begin(), parts.end());
    noteCell(slab, i);
  }
  mesh.cells = std::vector<Cell>();  // half of the memory
  result.newVertices = splitter.cutEdges().size();
  std::vector<double> bounds = {times.front()};
  bounds.insert(bounds.end(), at.begin(), at.end());
  bounds.push_back(times.back());
  for (model::Attribute& attribute : mesh.attributes) {
    if (attribute.domain == model::Domain::Vertex) {
      attribute = splitter.withNewRows(std::move(attribute));
    }
  }
  auto slabs = assembled(mesh, std::move(cells), cellsOf, bounds);
  if (!slabs) return slabs.error();
  result.mesh = std::move(*slabs);
  return result;
}

}  // namespace t4d::edit
