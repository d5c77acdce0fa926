#pragma once

#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "t4d/voxel4d/voxelize.h"
#include "tools/program/thread_limit.h"

namespace t4d::tools {

/// Adds `--frames` and `--frame-time`; `prefix` comes before what help says of them.
void addFrameTimes(CLI::App& command, voxel4d::FrameTimes& times, const std::string& prefix = "");

/// What the verbs that write a time series of .vdb share: their options, and the writing.
struct VoxelSeriesOptions {
  double voxelSize = 0;
  voxel4d::FrameTimes times;
  bool mask = false;
  std::string folder;
  std::optional<int> threads;
  bool json = false;

  void addTo(CLI::App& command);
};

/// Writes `solid` over `span` and says what was written; returns the exit code. `where` stands for
/// the solid in errors.
int writeVoxelSeries(const VoxelSeriesOptions& options, const model::TimeSpan& span,
                     const voxel4d::SolidAtTime& solid, const std::string& where);

}  // namespace t4d::tools
