#pragma once

#include <optional>
#include <string>

#include "tools/t4d/input.h"
#include "tools/t4d/observer.h"

namespace t4d::tools {

/// A length for each unit of time.
struct TimeScale {
  double value = 1;
  std::string reason;  ///< where it is from
};

/// The scale between space and time: as given, or the mean normal speed of the surface
/// (measure::meanNormalSpeed), or the size divided by the duration if nothing moves. One with which
/// all cells would be flat up to rounding is an error (Options).
Result<TimeScale> timeScaleOf(const std::optional<double>& given, const Input& input,
                              Observer& observer);

}  // namespace t4d::tools
