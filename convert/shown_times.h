#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "t4d/mesh.h"

namespace t4d::convert {

/// The seconds at which a body becomes shown (true) or hidden (false), in a flipbook with a frame
/// for each time. It is shown in the frames at whose times it exists. The first entry is at 0.
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
