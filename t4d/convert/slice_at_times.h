#pragma once

#include <span>
#include <vector>

#include "t4d/convert/slice.h"

namespace t4d::convert {

/// The solid at each of `times`, which may be in any order: result i is what sliceAtTime gives for
/// times[i], so a time outside the mesh is an error of its own. Reads each slab at most once, and
/// none that no time falls into; one slab is in memory beside the slices.
std::vector<Result<Slice>> sliceAtTimes(const model::Source& source, std::span<const double> times,
                                        const model::Progress& progress = {});

}  // namespace t4d::convert
