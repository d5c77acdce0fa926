#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "t4d/mesh.h"
#include "t4d/weave.h"
#include "tools/verbs/observer.h"

namespace t4d::verbs {

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

}  // namespace t4d::verbs
