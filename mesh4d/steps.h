#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "model/chords.h"
#include "t4d/error.h"
#include "t4d/motion.h"
#include "t4d/sweep.h"

namespace t4d::mesh4d {

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
