#include "t4d/voxel4d/frame.h"

#include <bit>

namespace t4d::voxel4d {

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
