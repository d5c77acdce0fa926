#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <type_traits>
#include <vector>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include "t4d/voxel4d/frame.h"

/// One frame from an array. For the sources of this folder only.
namespace t4d::voxel4d {

/// nx x ny x nz points, z varies fastest.
struct ArrayShape {
  std::array<std::size_t, 3> size{};

  std::size_t count() const { return size[0] * size[1] * size[2]; }
  /// To the next point along x, y or z.
  std::size_t stride(int axis) const {
    return axis == 0 ? size[1] * size[2] : axis == 1 ? size[2] : 1;
  }
  std::array<std::size_t, 3> blocks() const {
    const auto blocksOf = [](std::size_t points) { return (points + kBlockSize - 1) / kBlockSize; };
    return {blocksOf(size[0]), blocksOf(size[1]), blocksOf(size[2])};
  }
};

/// How the values of an array become a field: sign * (value - iso).
struct ArrayField {
  double sign = 1;
  double iso = 0;
  double outside = 0;  ///< value of points that are not in the array

  template <class T>
  double operator()(T value) const {
    return sign * (static_cast<double>(value) - iso);
  }
  /// Points outside the array are as far from the surface as `most`, the largest distance in it.
  /// Fails if T cannot tell that from the iso value.
  template <class T>
  Result<void> setOutside(double most) {
    outside = static_cast<double>(static_cast<T>(iso + sign * (most > 0 ? most : 1)));
    const double field = (*this)(outside);
    if (field > 0 && std::isfinite(field)) return {};
    return invalid(fmt::format("the values differ from the iso value {} by too little", iso));
  }
};

/// Without values for bools, which are true inside.
template <class T>
Frame frameOfArray(std::span<const T> values, const ArrayShape& shape, const ArrayField& field,
                   double time) {
  constexpr bool kHasValues = !std::is_same_v<T, bool>;
  const auto counts = shape.blocks();
  const std::size_t count = counts[0] * counts[1] * counts[2];
  std::vector<Block> blocks(count);
  const auto memory = std::make_shared<std::vector<std::array<T, 512>>>(kHasValues ? count : 0);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t index) {
    Block& block = blocks[index];
    T* const into = kHasValues ? (*memory)[index].data() : nullptr;
    const std::array<std::size_t, 3> at = {index / counts[2] / counts[1],
                                           index / counts[2] % counts[1], index % counts[2]};
    block.coord = {static_cast<std::int32_t>(at[0]), static_cast<std::int32_t>(at[1]),
                   static_cast<std::int32_t>(at[2])};
    for (std::size_t i = 0; i < 512; ++i) {
      const std::size_t x = kBlockSize * at[0] + i / 64;
      const std::size_t y = kBlockSize * at[1] + i / 8 % 8;
      const std::size_t z = kBlockSize * at[2] + i % 8;
      const bool given = x < shape.size[0] && y < shape.size[1] && z < shape.size[2];
      const T value = given ? values[x * shape.stride(0) + y * shape.stride(1) + z]
                            : static_cast<T>(field.outside);
      bool inside = false;
      if constexpr (kHasValues) {
        inside = field(value) < 0;
        into[i] = value;
      } else {
        inside = value;
      }
      if (inside) block.inside[i / 64] |= std::uint64_t{1} << (i % 64);
    }
    if constexpr (std::is_same_v<T, float>) {
      block.values = {into, nullptr, field.sign, field.iso};
    } else if constexpr (std::is_same_v<T, double>) {
      block.values = {nullptr, into, field.sign, field.iso};
    }
  });
  Frame frame;
  frame.time = time;
  if constexpr (kHasValues) {
    frame.outsideValue = field(field.outside);
    frame.owner = memory;
    frame.blocks = std::move(blocks);
  } else {
    for (const Block& block : blocks) {
      const auto all = [&](std::uint64_t word) {
        return std::ranges::all_of(block.inside, [&](std::uint64_t w) { return w == word; });
      };
      if (all(kAllBits)) {
        frame.tiles.push_back({block.coord, 1, 0});
      } else if (!all(0)) {
        frame.blocks.push_back(block);
      }
    }
  }
  return frame;
}

}  // namespace t4d::voxel4d
