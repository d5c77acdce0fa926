#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

namespace t4d::model {

/// The number of threads that the caller may use.
inline std::size_t threadCount() {
  return static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
}

/// The largest number of cells in slabs that threads process concurrently. On a slab with more
/// cells, all threads work together.
inline constexpr std::uint64_t kCellsAtOnce = std::uint64_t{1} << 20;

/// The number of slabs with `cells` cells to process concurrently. A thread whose slab must wait
/// for earlier ones continues with another.
inline std::size_t slabsAtOnce(std::uint64_t cells) {
  if (threadCount() == 1) return 1;
  const std::uint64_t fitting = kCellsAtOnce / std::max<std::uint64_t>(cells, 1);
  return std::clamp<std::size_t>(fitting, 1, 2 * threadCount());
}

/// Reads inputs 0 to count - 1 one by one, makes an item from each on all threads, and takes the
/// items one by one in order, until `take` returns false. At most `atOnce` items are in memory.
template <class Input, class Item, class Read, class Make, class Take>
void inOrder(std::size_t count, std::size_t atOnce, Read read, Make make, Take take) {
  std::size_t next = 0;
  std::atomic<bool> ended = false;
  const auto readNext = [&](tbb::flow_control& flow) {
    if (next < count && !ended) return read(next++);
    flow.stop();
    return Input();
  };
  const auto takeItem = [&](const Item& item) {
    if (!ended && !take(item)) ended = true;
  };
  tbb::parallel_pipeline(
      atOnce, tbb::make_filter<void, Input>(tbb::filter_mode::serial_in_order, readNext) &
                  tbb::make_filter<Input, Item>(tbb::filter_mode::parallel, make) &
                  tbb::make_filter<Item, void>(tbb::filter_mode::serial_in_order, takeItem));
}

/// inOrder for inputs that are the numbers 0 to count - 1 themselves.
template <class Item, class Make, class Take>
void inOrder(std::size_t count, std::size_t atOnce, Make make, Take take) {
  const auto number = [](std::size_t i) { return i; };
  inOrder<std::size_t, Item>(count, atOnce, number, make, take);
}

/// inOrder with at most one item per thread in memory.
template <class Item, class Make, class Take>
void inOrder(std::size_t count, Make make, Take take) {
  inOrder<Item>(count, threadCount(), make, take);
}

}  // namespace t4d::model
