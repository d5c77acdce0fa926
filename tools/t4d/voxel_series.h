#pragma once

#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "t4d/weave.h"
#include "tools/t4d/part_option.h"
#include "tools/verbs/voxel_series.h"
#include "voxel4d/frame_spacing.h"

namespace t4d::tools {

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
voxel4d::Between betweenOf(const std::optional<std::string>& name);

/// Reports on parts that are lost between frames, in text, in JSON, and by the exit code.
struct LostPartsOptions {
  bool fails = false;

  /// Adds `--fail-on-lost-parts`.
  void addTo(CLI::App& command);
  /// The exit code in place of `done`.
  int exitCode(const voxel4d::LostParts& parts, int done) const;
};

/// Shared by the verbs that write a time series of .vdb files: their options, and the writing.
struct VoxelSeriesOptions {
  double voxelSize = 0;
  voxel4d::FrameTimes times;
  bool mask = false;
  std::string folder;
  LostPartsOptions lostParts;
  PartOption part;
  bool json = false;

  /// Adds all options except --json and those of addFrameTimes.
  void addTo(CLI::App& command);
  /// The options for the library; `name` is that of the solid.
  verbs::VoxelSeriesOptions at(std::vector<double> frameTimes, std::string name) const;
};

/// Prints what was written of `frames` frames, as `json` if that is asked for; returns the exit
/// code. `identity` is that of the input of a part.
int reportVoxelSeries(const VoxelSeriesOptions& options, std::size_t frames,
                      const verbs::VoxelSeriesReport& written, nlohmann::ordered_json json,
                      nlohmann::ordered_json identity = {});

}  // namespace t4d::tools
