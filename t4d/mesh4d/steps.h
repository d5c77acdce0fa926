#pragma once

#include <cstdint>
#include <variant>
#include <vector>

#include "t4d/model/error.h"
#include "t4d/model/motion.h"

namespace t4d::mesh4d {

/// Keep the volume of every slice at least this fraction of the solid's: a step turns by at most
/// acos(2 R_Vmin - 1) (paper, section 4.2, eq. 2). Within [0, 1).
struct MinVolumeRatio {
  double ratio = 0.998;
};

/// A fixed number of steps per segment.
struct StepsPerSegment {
  std::uint64_t steps = 1;
};

/// Keep every point within this distance, in length units, of its true screw path at the same time.
/// At the middle of a step, a point at distance r from the axis deviates from its path by r (1 -
/// cos(angle / 2)).
struct MaxDeviation {
  double length = 0;
};

using StepRule = std::variant<MinVolumeRatio, StepsPerSegment, MaxDeviation>;

/// The maximum number of steps of a motion.
inline constexpr std::uint64_t kMaxSteps = 100'000'000;

/// The number of steps of each segment: at least 1, and enough that no step turns by more than half
/// a turn (unless StepsPerSegment asks for it). `points` are the vertices of the mesh before the
/// motion; only MaxDeviation uses them. Fails for a ratio outside [0, 1), zero steps, a deviation
/// that is not positive, and more than kMaxSteps.
Result<std::vector<std::uint64_t>> stepsOf(const model::Motion& motion, const StepRule& rule,
                                           const std::vector<model::Point3>& points);

}  // namespace t4d::mesh4d
