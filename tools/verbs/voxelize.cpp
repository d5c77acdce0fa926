#include "tools/verbs/voxelize.h"

#include <utility>

#include "t4d/weave.h"
#include "tools/verbs/members.h"

namespace t4d::verbs {

Result<VoxelSeriesReport> voxelize(model::TriangleMesh mesh, model::Motion motion,
                                   const VoxelSeriesOptions& options, Observer& observer) {
  return writeVoxelSeries(voxel4d::movingSolid(std::move(mesh), std::move(motion)), options,
                          observer);
}

void describe(Members& members, const VoxelizeReport& report) {
  members("mend", report.mended, "With --mend: the changes to the solid, as in t4d mend --json.",
          addMending)
      .onlyIf(!report.mended.empty());
  describe(members, report.written);
}

}  // namespace t4d::verbs
