#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "convert/frame_files.h"
#include "t4d/mesh.h"
#include "tools/t4d/input.h"
#include "tools/t4d/observer.h"
#include "tools/t4d/slice_write_options.h"

namespace t4d::tools {

class Members;

struct FramesOptions {
  convert::FrameNames names = {};  ///< of the files, as convert::frameNames makes them
  std::vector<double> times = {};  ///< none for 60, evenly spaced over the whole time
  bool light = false;              ///< as slice::SliceDetail::Light
  model::Part part = {};           ///< the share of the frames that is written; not of USD files
  SliceWriteOptions write = {};
  /// Velocities are per second of playback, as they always are in USD, not per time unit.
  bool inPlayback = false;
  double framesPerSecond = 24;  ///< of playback
};

struct FramesReport {
  convert::FrameFilesReport written;  ///< its notices have also gone to the observer
  std::filesystem::path manifest;     ///< of all frames, or of the part
  double firstTime = 0;               ///< of the frames that were written
  double lastTime = 0;
  bool ofGrids = false;      ///< OpenVDB grids, which have no triangles
  bool hasVelocity = false;  ///< whether velocities were written, or needed for colours
  /// The smallest and largest value of what gives colours, if they come from numbers.
  std::optional<std::array<double, 2>> colorRange = {};
  std::optional<double> quantizationError = {};  ///< how far a coordinate may be from its place
};

/// Writes the solid at each of the times to a file of its own, and their manifest
/// (convert::writeFrameFiles). Fails with Remedy::MoreFrames for velocities in the playback of one
/// frame, and if convert does.
Result<FramesReport> frames(const Input& input, const FramesOptions& options,
                            Observer& observer = nobody());

void describe(Members& members, const FramesReport& report);

}  // namespace t4d::tools
