#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "t4d/error.h"
#include "t4d/mesh.h"

namespace t4d::tools {

/// The times of a mesh that a curve in a text file shows, at every frame of its playback.
///
/// The file is a table of two columns that its first line names: `playback,time` has the time of
/// the mesh to show at a second of playback, and `playback,speed` the time of the mesh that passes
/// in a second there, of which the first row shows `span.begin`. Between rows, time or speed change
/// linearly. The first frame is at the first row, and the last one no later than the last row.
///
/// Fails, with the line, if the file is anything else, has more than `most` frames, or shows a time
/// outside `span`.
Result<std::vector<double>> timesOfCurve(const std::string& path, const model::TimeSpan& span,
                                         double framesPerSecond, std::uint64_t most);

}  // namespace t4d::tools
