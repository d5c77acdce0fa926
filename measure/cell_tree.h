#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "measure/moving_box.h"
#include "t4d/mesh.h"

namespace t4d::measure {

/// A tree of moving boxes over the cells of a slab during a window of time. Its leaves are runs of
/// consecutive cells that share a vertex: the cells of a prism, or most of those of a hypercube.
class CellTree {
 public:
  struct Node {
    MovingBox box;
    std::uint32_t second = 0;  ///< the second child, whose sibling is the next node; 0 for a leaf
    std::uint32_t firstCell = 0;  ///< of a leaf
    std::uint32_t cellCount = 0;
    std::uint32_t firstVertex = 0;  ///< of a leaf, in verticesOf
    std::uint32_t vertexCount = 0;

    bool isLeaf() const { return second == 0; }
  };

  /// Sets the boxes for a part of the slab's time. The tree is built anew unless the slab before
  /// had the same connectivity, by identity.
  void fit(const model::Slab& slab, const model::TimeSpan& window);

  /// The nodes, the root first; none for a slab without cells.
  std::span<const Node> nodes() const { return nodes_; }
  /// The vertices of a leaf's cells, each once.
  std::span<const std::uint32_t> verticesOf(const Node& leaf) const {
    return std::span(vertices_).subspan(leaf.firstVertex, leaf.vertexCount);
  }
  /// The most cells and vertices of a leaf.
  static constexpr std::size_t kMostCells = 16;
  static constexpr std::size_t kMostVertices = 1 + 3 * kMostCells;  // one is common to all
  /// The bounds of all cells in the window.
  model::Bounds4 bounds() const;

 private:
  void build(const model::Slab& slab);
  std::uint32_t buildNode(std::span<std::uint32_t> runs, std::span<const model::Point4> centers,
                          std::span<const std::uint32_t> starts);

  std::shared_ptr<const model::Connectivity> connectivity_;
  std::vector<Node> nodes_;
  std::vector<std::uint32_t> leaves_;  // nodes
  std::vector<std::uint32_t> vertices_;
};

}  // namespace t4d::measure
