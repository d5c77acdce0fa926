#include "measure/vertex_links.h"

#include <algorithm>
#include <array>

#include "model/union_find.h"

namespace t4d::measure {
namespace {

using LinkTriangle = std::array<std::uint32_t, 3>;

/// Tests one link at a time; reuses its buffers.
class SphereTest {
 public:
  /// A surface is a sphere when each edge has two triangles, the triangles are connected across
  /// edges, and V - E + F = 2: pinching a connected closed surface at a vertex only lowers that
  /// sum, and the sphere alone reaches 2.
  bool isSphere(const LinkTriangle* triangles, std::uint32_t count) {
    edges_.clear();
    vertices_.clear();
    for (std::uint32_t i = 0; i < count; ++i) {
      for (int side = 0; side < 3; ++side) {
        const std::uint32_t from = triangles[i][side];
        const std::uint32_t to = triangles[i][(side + 1) % 3];
        edges_.push_back({std::min(from, to), std::max(from, to), i});
        vertices_.push_back(from);
      }
    }
    if (edges_.size() % 2 != 0) return false;
    std::sort(edges_.begin(), edges_.end());
    sets_.reset(count);
    std::uint32_t parts = count;
    for (std::size_t i = 0; i < edges_.size(); i += 2) {
      const bool pair = edges_[i][0] == edges_[i + 1][0] && edges_[i][1] == edges_[i + 1][1];
      const bool third = i + 2 < edges_.size() && edges_[i][0] == edges_[i + 2][0] &&
                         edges_[i][1] == edges_[i + 2][1];
      if (!pair || third) return false;
      if (sets_.unite(edges_[i][2], edges_[i + 1][2])) --parts;
    }
    std::sort(vertices_.begin(), vertices_.end());
    const auto vertexCount = std::unique(vertices_.begin(), vertices_.end()) - vertices_.begin();
    const auto edgeCount = static_cast<std::ptrdiff_t>(edges_.size() / 2);
    return parts == 1 && vertexCount - edgeCount + static_cast<std::ptrdiff_t>(count) == 2;
  }

 private:
  std::vector<std::array<std::uint32_t, 3>> edges_;  // low, high, triangle
  std::vector<std::uint32_t> vertices_;
  model::UnionFind sets_;
};

/// The vertices from `first` to `last` (exclusive) that have cells and a link that is not a sphere,
/// numbered from `first`.
std::vector<std::uint32_t> nonManifoldVertices(const std::vector<model::Cell>& cells,
                                               std::uint32_t first, std::uint32_t last) {
  const std::uint32_t count = last - first;
  std::vector<std::size_t> begin(std::size_t{count} + 1, 0);
  for (const model::Cell& cell : cells) {
    for (const std::uint32_t vertex : cell) {
      if (vertex >= first && vertex < last) ++begin[vertex - first + 1];
    }
  }
  for (std::size_t i = 1; i < begin.size(); ++i) begin[i] += begin[i - 1];
  std::vector<LinkTriangle> triangles(begin.back());
  std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
  for (const model::Cell& cell : cells) {
    for (int corner = 0; corner < 4; ++corner) {
      const std::uint32_t vertex = cell[corner];
      if (vertex < first || vertex >= last) continue;
      triangles[next[vertex - first]++] = {cell[(corner + 1) % 4], cell[(corner + 2) % 4],
                                           cell[(corner + 3) % 4]};
    }
  }
  SphereTest test;
  std::vector<std::uint32_t> nonManifold;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::size_t size = begin[i + 1] - begin[i];
    if (size == 0) continue;  // no cell uses it
    if (!test.isSphere(triangles.data() + begin[i], static_cast<std::uint32_t>(size))) {
      nonManifold.push_back(i);
    }
  }
  return nonManifold;
}

}  // namespace

std::vector<std::uint32_t> nonManifoldInteriorVertices(const model::Connectivity& connectivity) {
  std::vector<std::uint32_t> nonManifold =
      nonManifoldVertices(connectivity.cells, connectivity.lowerCount, connectivity.firstUpper());
  for (std::uint32_t& vertex : nonManifold) vertex += connectivity.lowerCount;
  return nonManifold;
}

std::vector<std::uint32_t> nonManifoldLayerVertices(const model::Connectivity* before,
                                                    const model::Connectivity* after) {
  // Joined numbering: the layer, then the rest of the slab before, then the rest of the slab after.
  const std::uint32_t layer = before != nullptr ? before->upperCount : after->lowerCount;
  std::vector<model::Cell> cells;
  std::uint32_t firstOfRest = layer;
  const auto join = [&](const model::Connectivity& connectivity, std::uint32_t layerBegin) {
    const auto joined = [&](std::uint32_t vertex) {
      const std::uint32_t fromLayer = vertex - layerBegin;  // wraps to large below the layer
      if (vertex >= layerBegin && fromLayer < layer) return fromLayer;
      return firstOfRest + (vertex < layerBegin ? vertex : vertex - layer);
    };
    for (const model::Cell& cell : connectivity.cells) {
      const model::Cell renumbered{joined(cell[0]), joined(cell[1]), joined(cell[2]),
                                   joined(cell[3])};
      if (*std::min_element(renumbered.begin(), renumbered.end()) < layer) {
        cells.push_back(renumbered);
      }
    }
    firstOfRest += connectivity.vertexCount - layer;
  };
  if (before != nullptr) join(*before, before->firstUpper());
  if (after != nullptr) join(*after, 0);
  return nonManifoldVertices(cells, 0, layer);
}

}  // namespace t4d::measure
