#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

#ifndef T4D_SERIAL
#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/parallel_reduce.h>
#include <tbb/parallel_sort.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>
#endif

#include "model/progress.h"

/// Work on all threads: the only file that includes oneTBB. Without it (T4D_SERIAL) everything runs
/// in the thread of the caller, with the same results.
namespace t4d::model {

#ifdef T4D_SERIAL
inline constexpr bool kSerial = true;
#else
inline constexpr bool kSerial = false;
#endif

/// The number of threads that the caller may use.
inline std::size_t threadCount() {
#ifdef T4D_SERIAL
  return 1;
#else
  return static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
#endif
}

/// Limits the number of threads of this process while it exists.
class ThreadLimit {
 public:
#ifdef T4D_SERIAL
  explicit ThreadLimit(std::size_t /*threads*/) {}
#else
  explicit ThreadLimit(std::size_t threads)
      : limit_(tbb::global_control::max_allowed_parallelism, threads) {}

 private:
  tbb::global_control limit_;
#endif
};

/// Calls body(begin, end) for ranges of at most `grain` numbers that together are `begin` to `end`.
template <class Body>
void forRanges(std::size_t begin, std::size_t end, std::size_t grain, const Body& body) {
#ifdef T4D_SERIAL
  for (; begin < end; begin += std::min(grain, end - begin)) {
    body(begin, begin + std::min(grain, end - begin));
  }
#else
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(begin, end, grain),
      [&](const tbb::blocked_range<std::size_t>& some) { body(some.begin(), some.end()); },
      tbb::simple_partitioner());
#endif
}

/// Calls body(i) for each i below `count`.
template <class Index, class Body>
void forEach(Index count, const Body& body) {
#ifdef T4D_SERIAL
  for (Index i = 0; i < count; ++i) body(i);
#else
  tbb::parallel_for(Index{0}, count, body);
#endif
}

/// forEach for few calls that take long: a thread takes one at a time.
template <class Body>
void forEachTask(std::size_t count, const Body& body) {
  forRanges(0, count, 1, [&](std::size_t i, std::size_t) { body(i); });
}

/// forEach that reports progress, from the calling thread alone, which works along. Fails if it is
/// told to stop.
template <class Body>
Result<void> forEach(std::size_t count, const Progress& progress, const Body& body) {
  const auto caller = std::this_thread::get_id();
  std::atomic<std::size_t> done = 0;
  std::atomic<bool> ended = false;
  Result<void> result;
  forEach(count, [&](std::size_t i) {
    if (ended) return;
    body(i);
    const std::size_t now = ++done;
    if (std::this_thread::get_id() != caller || ended) return;
    result = report(progress, now, count);
    if (!result) ended = true;
  });
  return result;
}

/// Calls all of `works`, which may run at the same time.
template <class... Works>
void together(const Works&... works) {
#ifdef T4D_SERIAL
  (works(), ...);
#else
  tbb::parallel_invoke(works...);
#endif
}

/// Sorts by a strict weak order; equal elements end in any order.
template <class Iterator, class Less = std::less<>>
void sort(Iterator begin, Iterator end, const Less& less = {}) {
#ifdef T4D_SERIAL
  std::sort(begin, end, less);
#else
  tbb::parallel_sort(begin, end, less);
#endif
}

/// The values add(begin, end, Value()) of ranges of at most `grain` numbers below `count`, joined
/// in order. Ranges are halved, whatever the number of threads, and so sums are the same.
template <class Value, class Add, class Join>
Value reduce(std::size_t count, std::size_t grain, const Add& add, const Join& join) {
#ifdef T4D_SERIAL
  const auto half = [&](const auto& self, std::size_t begin, std::size_t end) -> Value {
    if (end - begin <= grain) return add(begin, end, Value());
    const std::size_t middle = begin + (end - begin) / 2;
    Value first = self(self, begin, middle);
    return join(std::move(first), self(self, middle, end));
  };
  return half(half, 0, count);
#else
  using Range = tbb::blocked_range<std::size_t>;
  return tbb::parallel_deterministic_reduce(
      Range(0, count, grain), Value(),
      [&](const Range& some, Value value) {
        return add(some.begin(), some.end(), std::move(value));
      },
      join);
#endif
}

/// Calls `work`, and returns what it returns. A thread that waits within it for a part of it does
/// not begin other work meanwhile, which could need the same lock or more memory.
template <class Work>
decltype(auto) isolate(const Work& work) {
#ifdef T4D_SERIAL
  return work();
#else
  return tbb::this_task_arena::isolate(work);
#endif
}

/// A value for each thread, which makes its own when it first asks.
template <class Value>
class PerThread {
 public:
  explicit PerThread(std::function<Value()> make = [] { return Value(); })
      : make_(std::move(make)) {}

  Value& local() {
    const std::scoped_lock lock(mutex_);
    std::unique_ptr<Value>& own = values_[std::this_thread::get_id()];
    if (!own) own = std::make_unique<Value>(make_());
    return *own;
  }
  /// Calls use(value) for the value of each thread, in any order.
  template <class Use>
  void each(const Use& use) const {
    for (const auto& [thread, value] : values_) use(*value);
  }

 private:
  std::mutex mutex_;
  std::function<Value()> make_;
  std::map<std::thread::id, std::unique_ptr<Value>> values_;
};

/// Work that another thread does, if one is free, while the owner goes on.
class Aside {
 public:
  template <class Work>
  void begin(const Work& work) {
#ifdef T4D_SERIAL
    work();
#else
    group_.run(work);
#endif
  }
  /// Waits until the work is done. To be called before the destructor.
  void wait() {
#ifndef T4D_SERIAL
    group_.wait();
#endif
  }

#ifndef T4D_SERIAL
 private:
  tbb::task_group group_;
#endif
};

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
void inOrder(std::size_t count, [[maybe_unused]] std::size_t atOnce, Read read, Make make,
             Take take) {
#ifdef T4D_SERIAL
  for (std::size_t next = 0; next < count; ++next) {
    const Item item = make(read(next));
    if (!take(item)) return;
  }
#else
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
#endif
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
