#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "t4d/mesh.h"

namespace t4d::model {

/// Consecutive vertices of a slab.
struct VertexRange {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;  ///< one more than the last

  std::uint32_t size() const { return end - begin; }
};

/// Some cells of a slab, and the vertices that they need.
struct CellBlock {
  /// Ranges in the lower layer, the interior, and the upper layer. They have no gaps, so some
  /// vertices may not be needed.
  std::array<VertexRange, 3> ranges;
  std::vector<Point4> vertices;  ///< of the ranges, in order
  std::vector<Cell> cells;       ///< as indices into `vertices`

  /// The number that a vertex of the block has in the slab.
  std::uint32_t numberInSlab(std::uint32_t vertex) const {
    for (const VertexRange& range : ranges) {
      if (vertex < range.size()) return range.begin + vertex;
      vertex -= range.size();
    }
    return 0;
  }
};

/// A slab that is read block by block, so that the whole slab need not be in memory. It has neither
/// means nor attributes.
class SlabBlocks : public VertexCounts {
 public:
  virtual ~SlabBlocks() = default;

  TimeSpan time;

  virtual std::size_t blockCount() const = 0;
  /// The bounds of the vertices of a block's cells.
  virtual const Bounds4& bounds(std::size_t block) const = 0;
  /// Called by several threads at once. Fails if the block contradicts bounds() or the counts of
  /// vertices, or if checkCells or checkVertices fails.
  virtual Result<CellBlock> read(std::size_t block) const = 0;
};

}  // namespace t4d::model
