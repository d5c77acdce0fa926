#pragma once

#include <filesystem>

#include "t4d/error.h"
#include "tools/bench/report.h"

namespace t4d::bench {

/// Measures weaving frames of voxels, with one thread and with two: the paper's cube (section 5.1),
/// a dense moving sphere, with `large` a thin shell of which the lattice holds little (48 million
/// cells a slab, minutes), each of them also written to a file in `folder`, and how time and memory
/// go with the number of frames. Making the frames is not counted.
Result<void> measureWovenVoxels(int repetitions, bool large, const std::filesystem::path& folder,
                                Report& report);

}  // namespace t4d::bench
