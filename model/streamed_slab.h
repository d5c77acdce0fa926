#pragma once

#include <cstdint>
#include <span>

#include "model/slab.h"

namespace t4d::model {

/// A slab that is made piece by piece, like those between two voxel frames, which can have more
/// cells than fit into memory. It has neither means nor attributes.
class StreamedSlab : public VertexCounts {
 public:
  virtual ~StreamedSlab() = default;

  TimeSpan time;
  std::uint64_t cellCount = 0;

  /// Sets `into` to the vertices, or the cells, from number `first` on; they must exist. Every call
  /// gives the same values. Safe to call from several threads at once.
  virtual void vertices(std::uint32_t first, std::span<Point4> into) const = 0;
  virtual void cells(std::uint64_t first, std::span<Cell> into) const = 0;
};

/// The complete slab in memory.
Slab assembled(const StreamedSlab& slab);

}  // namespace t4d::model
