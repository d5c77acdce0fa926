#pragma once

#include <atomic>
#include <cstddef>

#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

namespace t4d::slice {

/// Reads inputs 0 to count - 1 one by one, makes an item of each on all threads, and takes these
/// one by one in order, until `take` returns false. One item for each thread is in memory.
template <class Input, class Item, class Read, class Make, class Take>
void inOrder(std::size_t count, Read read, Make make, Take take) {
  std::size_t next = 0;
  std::atomic<bool> ended = false;
  const auto readNext = [&](tbb::flow_control& flow) {
    if (next == count || ended) {
      flow.stop();
      return Input();
    }
    return read(next++);
  };
  const auto takeItem = [&](const Item& item) {
    if (!ended && !take(item)) ended = true;
  };
  tbb::parallel_pipeline(
      static_cast<std::size_t>(tbb::this_task_arena::max_concurrency()),
      tbb::make_filter<void, Input>(tbb::filter_mode::serial_in_order, readNext) &
          tbb::make_filter<Input, Item>(tbb::filter_mode::parallel, make) &
          tbb::make_filter<Item, void>(tbb::filter_mode::serial_in_order, takeItem));
}

/// The same where the inputs are the numbers themselves.
template <class Item, class Make, class Take>
void inOrder(std::size_t count, Make make, Take take) {
  const auto number = [](std::size_t i) { return i; };
  inOrder<std::size_t, Item>(count, number, make, take);
}

}  // namespace t4d::slice
