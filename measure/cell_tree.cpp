#include "measure/cell_tree.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "model/parallel.h"

namespace t4d::measure {
namespace {

using model::Bounds4;
using model::Cell;
using model::Point4;

/// Where runs of consecutive cells that share a vertex start, and the number of cells at the end.
std::vector<std::uint32_t> startsOfRuns(std::span<const Cell> cells) {
  std::vector<std::uint32_t> starts;
  std::vector<std::uint32_t> shared;
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    std::erase_if(shared, [&](std::uint32_t vertex) {
      return std::ranges::find(cells[i], vertex) == cells[i].end();
    });
    if (!shared.empty() && i - starts.back() < CellTree::kMostCells) continue;
    starts.push_back(i);
    shared.assign(cells[i].begin(), cells[i].end());
  }
  starts.push_back(static_cast<std::uint32_t>(cells.size()));
  return starts;
}

}  // namespace

void CellTree::fit(const model::Slab& slab, const model::TimeSpan& window) {
  if (connectivity_ != slab.connectivity) build(slab);
  const model::TimeSpan whole{slab.timeBegin, slab.timeEnd};
  model::forEach(leaves_.size(), [&](std::size_t leaf) {
    Node& node = nodes_[leaves_[leaf]];
    std::array<Point4, kMostVertices> points;
    std::size_t count = 0;
    for (const std::uint32_t vertex : verticesOf(node)) points[count++] = slab.vertices[vertex];
    const MovingBox box = movingBoxOf(std::span(points).first(count), whole);
    MovingBox& part = node.box;
    part.begin = box.at(window.begin);
    part.end = box.at(window.end);
    part.time = window;
    part.occupied = {std::max(window.begin, box.occupied.begin),
                     std::min(window.end, box.occupied.end)};
  });
  // Children come after their parents.
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    if (nodes_[i].isLeaf()) continue;
    nodes_[i].box = nodes_[i + 1].box;
    nodes_[i].box.add(nodes_[nodes_[i].second].box);
  }
}

Bounds4 CellTree::bounds() const {
  Bounds4 bounds;
  if (nodes_.empty()) return bounds;
  const MovingBox& root = nodes_.front().box;
  model::Bounds3 space = root.begin;
  space.add(root.end);
  bounds.min << space.min, root.time.begin;
  bounds.max << space.max, root.time.end;
  return bounds;
}

void CellTree::build(const model::Slab& slab) {
  connectivity_ = slab.connectivity;
  nodes_.clear();
  leaves_.clear();
  vertices_.clear();
  const std::vector<Cell>& cells = connectivity_->cells;
  if (cells.empty()) return;
  const std::vector<std::uint32_t> starts = startsOfRuns(cells);
  std::vector<Point4> centers(starts.size() - 1);
  model::forEach(centers.size(), [&](std::size_t run) {
    Bounds4 bounds;
    for (std::uint32_t i = starts[run]; i < starts[run + 1]; ++i) {
      for (const std::uint32_t vertex : cells[i]) bounds.add(slab.vertices[vertex]);
    }
    centers[run] = (bounds.min + bounds.max) / 2;
  });
  std::vector<std::uint32_t> runs(centers.size());
  std::iota(runs.begin(), runs.end(), 0U);
  nodes_.reserve(2 * runs.size());
  buildNode(runs, centers, starts);
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    Node& node = nodes_[i];
    if (!node.isLeaf()) continue;
    leaves_.push_back(i);
    node.firstVertex = static_cast<std::uint32_t>(vertices_.size());
    const auto begin = static_cast<std::ptrdiff_t>(vertices_.size());
    for (std::uint32_t k = 0; k < node.cellCount; ++k) {
      const Cell& cell = cells[node.firstCell + k];
      vertices_.insert(vertices_.end(), cell.begin(), cell.end());
    }
    std::sort(vertices_.begin() + begin, vertices_.end());
    vertices_.erase(std::unique(vertices_.begin() + begin, vertices_.end()), vertices_.end());
    node.vertexCount = static_cast<std::uint32_t>(vertices_.size()) - node.firstVertex;
  }
}

std::uint32_t CellTree::buildNode(std::span<std::uint32_t> runs, std::span<const Point4> centers,
                                  std::span<const std::uint32_t> starts) {
  const auto number = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  if (runs.size() == 1) {
    nodes_[number].firstCell = starts[runs[0]];
    nodes_[number].cellCount = starts[runs[0] + 1] - starts[runs[0]];
    return number;
  }
  // At the median along the longest axis of space: all of a slab is near in time.
  Bounds4 bounds;
  for (const std::uint32_t run : runs) bounds.add(centers[run]);
  Eigen::Index axis = 0;
  const Point4 size = bounds.max - bounds.min;
  if (!(size.head<3>().maxCoeff(&axis) > 0)) axis = 3;
  const auto middle = runs.size() / 2;
  std::nth_element(runs.begin(), runs.begin() + static_cast<std::ptrdiff_t>(middle), runs.end(),
                   [&](std::uint32_t p, std::uint32_t q) {
                     const double x = centers[p][axis];
                     const double y = centers[q][axis];
                     return x != y ? x < y : p < q;
                   });
  buildNode(runs.first(middle), centers, starts);
  const std::uint32_t second = buildNode(runs.subspan(middle), centers, starts);
  nodes_[number].second = second;
  return number;
}

}  // namespace t4d::measure
