#include "t4d/edit/cut_into_slabs.h"

#include <algorithm>
#include <array>
#include <unordered_map>

#include <Eigen/LU>
#include <fmt/format.h>

#include "t4d/formats/mesh4d/polyhedron.h"

namespace t4d::edit {
namespace {

using formats::Mesh4d;
using model::Cell;
using model::Point4;

/// A slab of fewer cells costs more than it saves.
constexpr std::uint64_t kFewestCells = 256;

struct TimeRange {
  double begin;
  double end;
};

TimeRange rangeOf(const std::vector<Point4>& vertices, const Cell& cell) {
  TimeRange range{vertices[cell[0]][3], vertices[cell[0]][3]};
  for (const std::uint32_t corner : cell) {
    range.begin = std::min(range.begin, vertices[corner][3]);
    range.end = std::max(range.end, vertices[corner][3]);
  }
  return range;
}

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
    const auto [begin, end] = rangeOf(mesh.vertices, cell);
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

/// Two tetrahedra with the same corners are closed together, but where both are split their
/// sections would coincide, with four tetrahedra at each triangle.
Result<void> checkNoTwins(const Mesh4d& mesh, const std::vector<double>& cuts) {
  std::vector<Cell> split;
  for (Cell cell : mesh.cells) {
    const auto [begin, end] = rangeOf(mesh.vertices, cell);
    const auto next = std::ranges::upper_bound(cuts, begin);
    if (next == cuts.end() || end <= *next) continue;
    std::ranges::sort(cell);
    split.push_back(cell);
  }
  std::ranges::sort(split);
  const auto twin = std::ranges::adjacent_find(split);
  if (twin == split.end()) return {};
  return invalid(
      fmt::format("two tetrahedra have the same corners, the vertices {} {} {} {}: they "
                  "cannot be split at a time; remove them",
                  (*twin)[0], (*twin)[1], (*twin)[2], (*twin)[3]));
}

/// Splits cells at times; the vertices of the mesh grow.
class Splitter {
 public:
  explicit Splitter(std::vector<Point4>& vertices) : vertices_(vertices) {}

  /// The parts of a cell before and after a time that it reaches over.
  void split(const Cell& cell, double time, std::vector<Cell>& before, std::vector<Cell>& after) {
    std::array<int, 4> side{};
    for (int i = 0; i < 4; ++i) {
      const double t = vertices_[cell[i]][3];
      side[i] = t < time ? -1 : t > time ? 1 : 0;
    }
    place_.clear();
    for (int i = 0; i < 4; ++i) place_.push_back({cell[i], Point4::Unit(i)});
    splitPart(cell, side, -1, time, before);
    splitPart(cell, side, 1, time, after);
  }

  std::uint64_t newVertices() const { return cutVertices_.size(); }

 private:
  /// A vertex of the parts, by its barycentric coordinates in the cell. Those of a new vertex are
  /// taken as half and half: which way round a part's tetrahedra are does not depend on where on
  /// its edge it lies.
  struct Place {
    std::uint32_t vertex;
    Point4 weights;
  };

  void splitPart(const Cell& cell, const std::array<int, 4>& side, int which, double time,
                 std::vector<Cell>& into) {
    // The four triangles of the cell, clipped, and the section.
    std::array<std::vector<std::uint32_t>, 5> faces;
    for (int opposite = 0; opposite < 4; ++opposite) {
      std::array<int, 3> corners{};
      for (int i = 0, k = 0; i < 4; ++i) {
        if (i != opposite) corners[k++] = i;
      }
      auto& face = faces[opposite];
      for (int k = 0; k < 3; ++k) {
        const int a = corners[k];
        const int b = corners[(k + 1) % 3];
        if (side[a] == which || side[a] == 0) face.push_back(cell[a]);
        if (side[a] * side[b] < 0) face.push_back(cutVertex(cell, a, b, time));
      }
    }
    faces[4] = section(cell, side, time);
    std::vector<std::span<const std::uint32_t>> solid;
    for (const auto& face : faces) {
      if (face.size() >= 3) solid.emplace_back(face);
    }
    formats::pullPolyhedron(solid, [&](Cell part) {
      Eigen::Matrix4d weights;
      for (int i = 0; i < 4; ++i) {
        weights.row(i) = std::ranges::find(place_, part[i], &Place::vertex)->weights;
      }
      if (weights.determinant() < 0) std::swap(part[2], part[3]);
      into.push_back(part);
    });
  }

  /// The corners of the section in order around it.
  std::vector<std::uint32_t> section(const Cell& cell, const std::array<int, 4>& side,
                                     double time) {
    std::vector<int> below;
    std::vector<int> above;
    std::vector<std::uint32_t> corners;
    for (int i = 0; i < 4; ++i) {
      if (side[i] < 0) below.push_back(i);
      if (side[i] > 0) above.push_back(i);
      if (side[i] == 0) corners.push_back(cell[i]);
    }
    for (std::size_t i = 0; i < below.size(); ++i) {
      for (std::size_t j = 0; j < above.size(); ++j) {
        // With two on each side, the second row backwards.
        const std::size_t k = i % 2 == 0 ? j : above.size() - 1 - j;
        corners.push_back(cutVertex(cell, below[i], above[k], time));
      }
    }
    return corners;
  }

  std::uint32_t cutVertex(const Cell& cell, int a, int b, double time) {
    if (cell[a] > cell[b]) std::swap(a, b);
    const std::uint64_t edge = std::uint64_t{cell[a]} << 32 | cell[b];
    const auto [found, isNew] =
        cutVertices_.try_emplace(edge, static_cast<std::uint32_t>(vertices_.size()));
    if (isNew) {
      const Point4& from = vertices_[cell[a]];
      const Point4& to = vertices_[cell[b]];
      const double fraction = (time - from[3]) / (to[3] - from[3]);
      Point4 vertex = from + fraction * (to - from);
      vertex[3] = time;
      vertices_.push_back(vertex);
    }
    const std::uint32_t vertex = found->second;
    if (std::ranges::find(place_, vertex, &Place::vertex) == place_.end()) {
      place_.push_back({vertex, (Point4::Unit(a) + Point4::Unit(b)) / 2});
    }
    return vertex;
  }

  std::vector<Point4>& vertices_;
  std::unordered_map<std::uint64_t, std::uint32_t> cutVertices_;  // by edge
  std::vector<Place> place_;                                      // of the cell at hand
};

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
  if (auto good = checkNoTwins(mesh, at); !good) return pass(good.error());
  std::vector<std::vector<Cell>> cells(at.size() + 1);
  Splitter splitter(mesh.vertices);
  std::vector<Cell> parts;
  std::vector<Cell> after;
  for (const Cell& cell : mesh.cells) {
    const auto [begin, end] = rangeOf(mesh.vertices, cell);
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
        if (rangeOf(mesh.vertices, part).end <= at[slab]) {
          cells[slab].push_back(part);
        } else if (rangeOf(mesh.vertices, part).begin >= at[slab]) {
          after.push_back(part);
        } else {
          splitter.split(part, at[slab], cells[slab], after);
        }
      }
      parts = after;
    }
    cells[slab].insert(cells[slab].end(), parts.begin(), parts.end());
  }
  result.newVertices = splitter.newVertices();
  std::vector<double> bounds = {times.front()};
  bounds.insert(bounds.end(), at.begin(), at.end());
  bounds.push_back(times.back());
  auto slabs = assembled(mesh.vertices, std::move(cells), bounds);
  if (!slabs) return pass(slabs.error());
  result.mesh = std::move(*slabs);
  return result;
}

}  // namespace t4d::edit
