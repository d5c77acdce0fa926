#include "t4d/voxel4d/frame.h"

#include <algorithm>
#include <bit>

namespace t4d::voxel4d {

std::size_t valueSizeOf(const Frame& frame) {
  const auto sizeOf = [](const Block& block) -> std::size_t {
    if (block.values.floats != nullptr) return sizeof(float);
    return block.values.doubles != nullptr ? sizeof(double) : 0;
  };
  const std::size_t size = frame.blocks.empty() ? 0 : sizeOf(frame.blocks.front());
  const auto isAlike = [&](const Block& block) { return sizeOf(block) == size; };
  return std::ranges::all_of(frame.blocks, isAlike) ? size : 0;
}

std::uint64_t countInside(const Frame& frame) {
  std::uint64_t count = 0;
  for (const Block& block : frame.blocks) {
    for (const std::uint64_t word : block.inside) count += std::popcount(word);
  }
  for (const InsideTile& tile : frame.tiles) {
    const auto points = static_cast<std::uint64_t>(tile.size) * kBlockSize;
    count += points * points * points;
  }
  return count;
}

}  // namespace t4d::voxel4d
