#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "t4d/model/body.h"

namespace t4d::convert {

/// From which second on a body is shown (true) or hidden, in a flipbook with a frame for each time:
/// in the frames at whose times it exists. One entry for each change, the first at 0.
inline std::vector<std::pair<double, bool>> shownTimes(const model::Body& body,
                                                       std::span<const double> times,
                                                       double framesPerSecond) {
  std::vector<std::pair<double, bool>> shown;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const bool there = model::timeWithin(*body.source, times[i]).has_value();
    if (shown.empty() || shown.back().second != there) {
      shown.emplace_back(static_cast<double>(i) / framesPerSecond, there);
    }
  }
  return shown;
}

}  // namespace t4d::convert
