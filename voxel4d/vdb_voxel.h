#pragma once

#include <fmt/format.h>

#include "t4d/error.h"

namespace t4d::voxel4d {

/// OpenVDB makes no grid of smaller voxels: it takes a scale whose cube is below 3e-15 for zero. It
/// reads such grids, though.
inline constexpr double kFinestVoxel = 1e-4;

/// Fails for voxels that no .vdb is written with.
inline Result<void> checkVdbVoxel(double voxelSize) {
  if (voxelSize >= kFinestVoxel) return {};
  return fail(
      ErrorCode::Unsupported,
      fmt::format("voxels of {} are too small for a .vdb, which takes {} or more: scale the "
                  "solid, for instance from metres to millimetres",
                  voxelSize, kFinestVoxel));
}

}  // namespace t4d::voxel4d
