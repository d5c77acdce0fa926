#include "voxel4d/region_border.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace t4d::voxel4d {
namespace {

std::int64_t along(const Coord& coord, int axis) {
  return std::int64_t{kBlockSize} * (axis == 0 ? coord.x : axis == 1 ? coord.y : coord.z);
}

/// The points of a block's word that have a coordinate of 0 to 7 along y or z.
std::uint64_t planeBits(int axis, unsigned at) {
  constexpr std::uint64_t kRow = 0xFF;                   // along z
  constexpr std::uint64_t kColumn = 0x0101010101010101;  // along y
  return axis == 1 ? kRow << (8 * at) : kColumn << at;
}

bool isInsideAt(const BlockMask& inside, int axis, unsigned at) {
  if (axis == 0) return inside[at] != 0;
  const std::uint64_t bits = planeBits(axis, at);
  return std::ranges::any_of(inside, [&](std::uint64_t word) { return (word & bits) != 0; });
}

}  // namespace

RegionBorder::RegionBorder(const std::array<IndexRange, 3>& region,
                           const std::array<std::int64_t, 3>& offset)
    : offset_(offset) {
  for (int axis = 0; axis < 3; ++axis) {
    if (region[axis].begin) sides_.push_back({axis, *region[axis].begin});
    if (region[axis].end) sides_.push_back({axis, *region[axis].end - 1});
  }
}

void RegionBorder::look(const Frame& frame) {
  for (auto& [axis, at, reached] : sides_) {
    const auto reaches = [&, axis = axis, at = at](const Coord& coord, std::int64_t points) {
      const std::int64_t first = along(coord, axis);
      return first <= at && at < first + points;
    };
    reached = reached ||
              std::ranges::any_of(frame.tiles,
                                  [&](const InsideTile& tile) {
                                    return reaches(tile.coord, kBlockSize * tile.size);
                                  }) ||
              std::ranges::any_of(frame.blocks, [&, axis = axis, at = at](const Block& block) {
                return reaches(block.coord, kBlockSize) &&
                       isInsideAt(block.inside, axis,
                                  static_cast<unsigned>(at - along(block.coord, axis)));
              });
  }
}

std::string RegionBorder::notice() const {
  std::vector<std::string> places;
  for (const auto& [axis, at, reached] : sides_) {
    if (reached) places.push_back(fmt::format("{} = {}", "xyz"[axis], at + offset_[axis]));
  }
  if (places.empty()) return {};
  return fmt::format("the solid reaches the border of the region and is closed there: at {}",
                     fmt::join(places, ", "));
}

}  // namespace t4d::voxel4d
