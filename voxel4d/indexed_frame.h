#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "t4d/frames.h"
#include "voxel4d/coord_index.h"

namespace t4d::voxel4d {

/// A frame whose blocks and tiles are found by their coordinates.
class IndexedFrame : public Frame {
 public:
  IndexedFrame() = default;
  explicit IndexedFrame(Frame frame);

  /// The number of the block.
  std::optional<std::uint32_t> blockAt(const Coord& coord) const { return blocks_.find(coord); }
  /// The number of the tile that a block is in.
  std::optional<std::uint32_t> tileAt(const Coord& coord) const;

 private:
  struct TileLevel {
    std::int32_t size = 1;
    CoordIndex tiles;  // by coord / size
  };
  CoordIndex blocks_;
  std::vector<TileLevel> tileLevels_;
};

}  // namespace t4d::voxel4d
