#pragma once

#include <atomic>
#include <cstddef>
#include <thread>

#include <tbb/parallel_for.h>

#include "model/progress.h"

namespace t4d::measure {

using model::partOf;

/// Calls body(i) for each i below `count` on all threads. Progress is reported from the calling
/// thread alone, which works along.
template <class Body>
void parallelFor(std::size_t count, const model::Progress& progress, const Body& body) {
  const auto caller = std::this_thread::get_id();
  std::atomic<std::size_t> done = 0;
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    body(i);
    const std::size_t now = ++done;
    if (progress && std::this_thread::get_id() == caller) {
      progress(static_cast<double>(now) / static_cast<double>(count));
    }
  });
}

}  // namespace t4d::measure
