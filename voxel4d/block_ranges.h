#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <ranges>
#include <span>
#include <vector>

#include "model/parallel.h"

namespace t4d::voxel4d {

/// Sets `into` to the elements from number `first` on, where each of `blocks` blocks makes its own
/// in one go: `make(block, into)` those numbered beginOf(block) to beginOf(block + 1).
template <class T, class BeginOf, class Make>
void makeRange(std::uint64_t first, std::span<T> into, std::size_t blocks, BeginOf beginOf,
               Make make) {
  if (into.empty()) return;
  const std::uint64_t last = first + into.size();
  const auto all = std::views::iota(std::size_t{0}, blocks);
  const std::size_t from = *std::ranges::upper_bound(all, first, {}, beginOf) - 1;
  const std::size_t to = *std::ranges::lower_bound(all, last, {}, beginOf);
  const auto makeBlock = [&](std::size_t block) {
    const std::uint64_t begin = beginOf(block);
    const std::uint64_t end = beginOf(block + 1);
    if (begin >= first && end <= last) {
      make(block, into.data() + (begin - first));
      return;
    }
    std::vector<T> whole(end - begin);
    make(block, whole.data());
    const std::uint64_t wanted = std::max(begin, first);
    std::copy(whole.begin() + static_cast<std::ptrdiff_t>(wanted - begin),
              whole.begin() + static_cast<std::ptrdiff_t>(std::min(end, last) - begin),
              into.begin() + static_cast<std::ptrdiff_t>(wanted - first));
  };
  constexpr std::size_t kTask = 8192;  // elements, which are made in the time of many task switches
  const std::size_t grain = 1 + (to - from) * kTask / into.size();
  model::forRanges(from, to, grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t block = begin; block < end; ++block) makeBlock(block);
  });
}

}  // namespace t4d::voxel4d
