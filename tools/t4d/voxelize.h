#pragma once

#include "t4d/motion.h"
#include "t4d/surface.h"
#include "tools/t4d/mending.h"
#include "tools/t4d/voxel_series.h"

namespace t4d::tools {

class Members;

struct VoxelizeReport {
  VoxelSeriesReport written;
  std::vector<MendedBody> mended;  ///< with --mend
};

/// Writes a closed triangle mesh that moves as a time series of .vdb files, at times such as those
/// of motionFrameTimes. Fails as writeVoxelSeries does.
Result<VoxelSeriesReport> voxelize(model::TriangleMesh mesh, model::Motion motion,
                                   const VoxelSeriesOptions& options,
                                   Observer& observer = nobody());

void describe(Members& members, const VoxelizeReport& report);

}  // namespace t4d::tools
