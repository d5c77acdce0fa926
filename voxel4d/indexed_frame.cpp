#include "voxel4d/indexed_frame.h"

#include <bit>
#include <map>
#include <utility>

namespace t4d::voxel4d {
namespace {

Coord scaledDown(const Coord& coord, std::int32_t size) {
  // Sizes are powers of two; an arithmetic shift rounds down for negative numbers too.
  const int shift = std::countr_zero(static_cast<std::uint32_t>(size));
  return {coord.x >> shift, coord.y >> shift, coord.z >> shift};
}

}  // namespace

IndexedFrame::IndexedFrame(Frame frame) : Frame(std::move(frame)) {
  blocks_.reserve(blocks.size());
  for (std::uint32_t i = 0; i < blocks.size(); ++i) blocks_.add(blocks[i].coord, i);
  std::map<std::int32_t, std::vector<std::uint32_t>> bySize;
  for (std::uint32_t i = 0; i < tiles.size(); ++i) bySize[tiles[i].size].push_back(i);
  for (const auto& [size, ofSize] : bySize) {
    TileLevel& level = tileLevels_.emplace_back(TileLevel{size, {}});
    level.tiles.reserve(ofSize.size());
    for (const std::uint32_t i : ofSize) level.tiles.add(scaledDown(tiles[i].coord, size), i);
  }
}

std::optional<std::uint32_t> IndexedFrame::tileAt(const Coord& coord) const {
  for (const TileLevel& level : tileLevels_) {
    if (const auto found = level.tiles.find(scaledDown(coord, level.size))) return found;
  }
  return std::nullopt;
}

}  // namespace t4d::voxel4d
