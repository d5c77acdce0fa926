#pragma once

#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "mesh4d/prism.h"
#include "model/chords.h"
#include "model/error.h"
#include "model/motion.h"

namespace t4d::mesh4d {

/// Keeps the volume of every slice at least at this fraction, R_Vmin, of the solid's: a step turns
/// by at most acos(2 R_Vmin - 1) (paper, section 4.2, eq. 2). In [0, 1).
struct MinVolumeRatio {
  double ratio = 0.998;
};

/// A fixed number of steps per segment.
struct StepsPerSegment {
  std::uint64_t steps = 1;
};

/// Keeps the Hausdorff distance between every slice and the true solid at the same time within this
/// length. model::Chords bounds the deviation of vertices and of the points between them.
struct MaxDeviation {
  double length = 0;
};

using StepRule = std::variant<MinVolumeRatio, StepsPerSegment, MaxDeviation>;

/// The maximum number of steps of a motion, if no other is given.
inline constexpr std::uint64_t kMaxSteps = 100'000'000;

/// For each segment, the numbers that bound the deviation of its steps: the largest distance of a
/// vertex from its axis, and the longest edge across the axis. Zero if the segment does not turn.
std::vector<model::Chords> chordsOf(const model::Motion& motion, const model::TriangleMesh& mesh,
                                    PrismSplit split);

/// The number of steps of each segment: at least 1, and enough that no step turns by more than half
/// a turn (unless StepsPerSegment asks for it). `chords` is the result of chordsOf; only
/// MaxDeviation uses it. Fails for a ratio outside [0, 1), zero steps, a deviation that is not
/// positive, and more than `most` steps.
Result<std::vector<std::uint64_t>> stepsOf(const model::Motion& motion, const StepRule& rule,
                                           std::span<const model::Chords> chords = {},
                                           std::uint64_t most = kMaxSteps);

/// Fails for a ratio outside [0, 1), zero steps and a deviation that is not positive.
Result<void> checkRule(const StepRule& rule);

/// The largest bound of any step, in length units.
double largestDeviation(const model::Motion& motion, std::span<const std::uint64_t> steps,
                        std::span<const model::Chords> chords);

}  // namespace t4d::mesh4d
