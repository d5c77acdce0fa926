#pragma once

#include <span>
#include <vector>

#include "t4d/collide.h"

namespace t4d::measure {

/// Sets the deepest time of each interval and the volume of the overlap then, and whether it
/// overlaps if that was not known: cells that have faces in common do not cross, and yet what they
/// bound may overlap. The largest overlap is sought from samples (kOverlapSamples of them, as
/// many layers of each body, and ContactInterval::crossing, then golden sections about the
/// largest), so it is a lower bound.
Result<void> measureOverlaps(const model::Source& a, const model::Source& b,
                             std::span<ContactInterval> intervals);

/// The volume of the overlap at each time, which both bodies must reach, to a few per cent.
Result<std::vector<double>> overlapVolumes(const model::Source& a, const model::Source& b,
                                           std::span<const double> times);

inline constexpr int kOverlapSamples = 16;

}  // namespace t4d::measure
