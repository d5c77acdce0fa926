#include "edit/separate_touching.h"

#include <algorithm>
#include <array>
#include <map>
#include <unordered_map>
#include <utility>

namespace t4d::edit {
namespace {

using model::Cell;

/// Cells that have a vertex, or an edge, in common, in classes of those that triangles with it
/// connect.
std::vector<std::vector<std::uint32_t>> fansOf(const std::vector<Cell>& cells,
                                               const std::vector<std::uint32_t>& around,
                                               const std::vector<std::uint32_t>& common) {
  std::vector<std::uint32_t> parent(around.size());
  const auto root = [&](std::uint32_t item) {
    while (parent[item] != item) item = parent[item] = parent[parent[item]];
    return item;
  };
  std::map<std::array<std::uint32_t, 2>, std::uint32_t> ofTriangle;  // by its other corners
  for (std::uint32_t i = 0; i < around.size(); ++i) {
    parent[i] = i;
    std::vector<std::uint32_t> others;
    for (const std::uint32_t corner : cells[around[i]]) {
      if (std::ranges::find(common, corner) == common.end()) others.push_back(corner);
    }
    std::ranges::sort(others);
    const auto meet = [&](std::array<std::uint32_t, 2> triangle) {
      const auto [at, isNew] = ofTriangle.try_emplace(triangle, i);
      if (!isNew) parent[root(i)] = root(at->second);
    };
    if (others.size() == 2) {
      for (const std::uint32_t other : others) meet({other, other});
    } else {
      for (std::size_t k = 0; k < 3; ++k) meet({others[k == 0 ? 1 : 0], others[k == 2 ? 1 : 2]});
    }
  }
  std::map<std::uint32_t, std::vector<std::uint32_t>> byRoot;
  for (std::uint32_t i = 0; i < around.size(); ++i) byRoot[root(i)].push_back(around[i]);
  std::vector<std::vector<std::uint32_t>> fans;
  for (auto& [number, fan] : byRoot) fans.push_back(std::move(fan));
  return fans;
}

class Separation {
 public:
  Separation(double time, std::vector<model::Point4>& vertices, CellSplitter& splitter,
             std::vector<Cell>& cells, std::vector<std::uint32_t>& cellOf)
      : time_(time), vertices_(vertices), splitter_(splitter), cells_(cells), cellOf_(cellOf) {}

  /// Divides edges; false if there is nothing more to divide. A cell is divided once at a time.
  bool divideEdges() {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<std::uint32_t>> ofEdges;
    for (std::uint32_t i = 0; i < cells_.size(); ++i) {
      for (const std::uint32_t u : cells_[i]) {
        for (const std::uint32_t w : cells_[i]) {
          if (u < w && isAt(u) && isAt(w)) ofEdges[{u, w}].push_back(i);
        }
      }
    }
    std::vector<char> divided(cells_.size(), 0);
    bool any = false;
    for (const auto& [edge, around] : ofEdges) {
      const auto fans = fansOf(cells_, around, {edge.first, edge.second});
      if (fans.size() < 2) continue;
      any = true;
      const auto isDivided = [&](std::uint32_t cell) { return divided[cell] != 0; };
      if (std::ranges::any_of(around, isDivided)) continue;
      for (const auto& fan : fans) {
        const std::uint32_t middle = splitter_.add({edge.first, edge.second, 0.5});
        for (const std::uint32_t cell : fan) {
          divided[cell] = 1;
          Cell other = cells_[cell];
          *std::ranges::find(cells_[cell], edge.second) = middle;
          *std::ranges::find(other, edge.first) = middle;
          cells_.push_back(other);
          cellOf_.push_back(cellOf_[cell]);
        }
      }
    }
    return any;
  }

  void copyVertices() {
    std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> ofVertices;
    for (std::uint32_t i = 0; i < cells_.size(); ++i) {
      for (const std::uint32_t v : cells_[i]) {
        if (isAt(v)) ofVertices[v].push_back(i);
      }
    }
    std::vector<std::uint32_t> inOrder;
    for (const auto& [vertex, around] : ofVertices) inOrder.push_back(vertex);
    std::ranges::sort(inOrder);
    for (const std::uint32_t vertex : inOrder) {
      const auto fans = fansOf(cells_, ofVertices[vertex], {vertex});
      for (std::size_t k = 1; k < fans.size(); ++k) {
        const std::uint32_t copy = splitter_.add({vertex, vertex, 0});
        for (const std::uint32_t cell : fans[k]) *std::ranges::find(cells_[cell], vertex) = copy;
      }
    }
  }

 private:
  bool isAt(std::uint32_t vertex) const { return vertices_[vertex][3] == time_; }

  double time_;
  std::vector<model::Point4>& vertices_;
  CellSplitter& splitter_;
  std::vector<Cell>& cells_;
  std::vector<std::uint32_t>& cellOf_;
};

}  // namespace

void separateTouching(double time, std::vector<model::Point4>& vertices, CellSplitter& splitter,
                      std::vector<Cell>& cells, std::vector<std::uint32_t>& cellOf) {
  Separation separation(time, vertices, splitter, cells, cellOf);
  while (separation.divideEdges()) {
  }
  separation.copyVertices();
}

}  // namespace t4d::edit
