#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "t4d/model/geometry.h"
#include "t4d/model/slab.h"

namespace t4d::model {

/// Consecutive vertices of a slab.
struct VertexRange {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;  ///< one more than the last

  std::uint32_t size() const { return end - begin; }
};

/// Some cells of a slab, and the vertices that they need.
struct CellBlock {
  /// Of the lower layer, the interior, and the upper layer; without gaps, but not all are needed.
  std::array<VertexRange, 3> ranges;
  std::vector<Point4> vertices;  ///< those of the ranges, one after another
  std::vector<Cell> cells;       ///< of numbers in `vertices`

  /// The number in the slab of a vertex of the block.
  std::uint32_t numberInSlab(std::uint32_t vertex) const {
    for (const VertexRange& range : ranges) {
      if (vertex < range.size()) return range.begin + vertex;
      vertex -= range.size();
    }
    return 0;
  }
};

/// A slab that is read block by block, so that it need not be in memory whole. It has neither means
/// nor attributes.
class SlabBlocks : public VertexCounts {
 public:
  virtual ~SlabBlocks() = default;

  TimeSpan time;

  virtual std::size_t blockCount() const = 0;
  /// Of the vertices of a block's cells.
  virtual const Bounds4& bounds(std::size_t block) const = 0;
  /// Called by several threads at once. Fails if the block is not what bounds() and the counts of
  /// vertices say, and if checkCells or checkVertices does.
  virtual Result<CellBlock> read(std::size_t block) const = 0;
};

}  // namespace t4d::model
