#include "tools/verbs/voxelize.h"

#include <utility>

#include "t4d/weave.h"

namespace t4d::verbs {

Result<VoxelSeriesReport> voxelize(model::TriangleMesh mesh, model::Motion motion,
                                   const VoxelSeriesOptions& options, Observer& observer) {
  return writeVoxelSeries(voxel4d::movingSolid(std::move(mesh), std::move(motion)), options,
                          observer);
}

}  // namespace t4d::verbs
