#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "t4d/mesh.h"
#include "t4d/weave.h"
#include "tools/t4d/observer.h"
#include "tools/t4d/part_option.h"
#include "voxel4d/frame_spacing.h"

namespace t4d::tools {
class Members;

/// Options for writing a solid as a time series of .vdb files.
struct VoxelSeriesOptions {
  std::vector<double> times = {};  ///< of the frames, increasing
  double voxelSize = 1;            ///< as voxel4d::VoxelizeOptions::voxelSize
  bool mask = false;               ///< as voxel4d::VoxelizeOptions::mask
  model::Part part = {};           ///< as voxel4d::VoxelizeOptions::part
  std::string folder = {};         ///< for frame_0000.vdb, ...; created if missing
  std::string name = {};           ///< of the solid: where errors are that name no other place
  /// The function that voxel4d::writeVoxelFrames calls before renaming.
  std::function<Result<void>()> beforeRenaming = {};
};

struct VoxelSeriesReport {
  voxel4d::VoxelSeries series;
  model::TimeSpan time = {};  ///< of the first and the last frame that is written
  double seconds = 0;
  std::vector<std::string> notices = {};
};

/// Writes the frames (voxel4d::writeVoxelFrames). Fails as that does, and (Options) if there are
/// fewer times than parts.
Result<VoxelSeriesReport> writeVoxelSeries(const voxel4d::SolidAtTime& solid,
                                           const VoxelSeriesOptions& options,
                                           Observer& observer = nobody());

/// Adds a notice if frames have no point inside.
void noticeEmptyFrames(const voxel4d::VoxelSeries& series, std::vector<std::string>& notices);

void describe(Members& members, const VoxelSeriesReport& report);

/// Adds `--frames` and `--frame-time`. `prefix` starts their help; `otherwise` ends that of
/// `--frames` and says what happens without either.
void addFrameTimes(CLI::App& command, voxel4d::FrameTimes& times, const std::string& prefix,
                   const std::string& otherwise);

/// The value of `otherwise` for verbs that use motionFrameTimes.
inline constexpr const char* kFramesByMotion = " (default: at most one voxel of motion per frame)";

/// The values of `--caps` for voxel4d; flat is the default.
const std::vector<std::string>& voxelCaps();
bool isVoxelCaps(const std::string& name);

/// The style of that name; flat for any other.
voxel4d::CapStyle voxelCapStyle(const std::string& name);

/// Adds `--between`; distance is the default. `prefix` starts its help.
void addBetween(CLI::App& command, std::optional<std::string>& between, const std::string& prefix);
voxel4d::Between chosenBetween(const std::optional<std::string>& name);

/// Reports on parts that are lost between frames, in text, in JSON, and by the exit code.
struct LostPartsOptions {
  bool fails = false;

  /// Adds `--fail-on-lost-parts`.
  void addTo(CLI::App& command);
  /// The exit code in place of `done`.
  int exitCode(const voxel4d::LostParts& parts, int done) const;
};

/// Shared by the verbs that write a time series of .vdb files: their options, and the writing.
struct VoxelSeriesArguments {
  VoxelSeriesOptions write = {};  ///< but for what `at` adds
  voxel4d::FrameTimes times;
  LostPartsOptions lostParts;
  PartOption part;
  bool json = false;

  /// Adds all options except --json and those of addFrameTimes.
  void addTo(CLI::App& command);
  /// The options for the library; `name` is that of the solid.
  VoxelSeriesOptions at(std::vector<double> frameTimes, std::string name) const;
};

/// Prints what was written of `frames` frames, as `json` if that is asked for; returns the exit
/// code. `identity` is that of the input of a part.
int reportVoxelSeries(const VoxelSeriesArguments& options, std::size_t frames,
                      const VoxelSeriesReport& written, nlohmann::ordered_json json,
                      nlohmann::ordered_json identity = {});

}  // namespace t4d::tools
