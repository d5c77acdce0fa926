#pragma once

#include <atomic>
#include <cstddef>

#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

namespace t4d::convert {

/// Makes items 0 to count - 1 on all threads and takes them one by one in this order, until `take`
/// returns false. One item for each thread is in memory.
template <class Item, class Make, class Take>
void inOrder(std::size_t count, Make make, Take take) {
  std::size_t next = 0;
  std::atomic<bool> ended = false;
  const auto number = [&](tbb::flow_control& flow) {
    if (next == count || ended) flow.stop();
    return next++;
  };
  const auto takeItem = [&](const Item& item) {
    if (!ended && !take(item)) ended = true;
  };
  tbb::parallel_pipeline(
      static_cast<std::size_t>(tbb::this_task_arena::max_concurrency()),
      tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order, number) &
          tbb::make_filter<std::size_t, Item>(tbb::filter_mode::parallel, make) &
          tbb::make_filter<Item, void>(tbb::filter_mode::serial_in_order, takeItem));
}

}  // namespace t4d::convert
