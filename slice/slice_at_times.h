#pragma once

#include <span>
#include <vector>

#include "slice/slice.h"

namespace t4d::slice {

/// The solid at each of `times`, which may be in any order. Result i is that of sliceAtTime for
/// times[i], so a time outside the mesh is an error in that result only. Reads each slab at most
/// once, and only slabs that contain one of the times. One slab is in memory besides the slices.
std::vector<Result<Slice>> sliceAtTimes(const model::Source& source, std::span<const double> times,
                                        const model::Progress& progress = {},
                                        WithMotion withMotion = WithMotion::No);

}  // namespace t4d::slice
