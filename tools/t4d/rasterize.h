#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tools/t4d/input.h"
#include "tools/t4d/voxel_series.h"

namespace t4d::tools {

class Members;

/// Writes slices of a 4D mesh, all bodies as one solid, as a time series of .vdb files. The
/// observer gets noticeOfOrigin. Fails as writeVoxelSeries and measure::solidAt do.
Result<VoxelSeriesReport> rasterize(const Input& input, const VoxelSeriesOptions& options,
                                    Observer& observer = nobody());

/// A note on what .vdb files cannot say about a mesh whose origin was moved; "" for another mesh.
std::string noticeOfOrigin(const Input& input);

/// Level sets with a manifest, as other frames have.
struct GridFramesReport {
  VoxelSeriesReport written;
  std::filesystem::path manifest;
};

/// Writes level sets as rasterize does, and the manifest of convert::writeManifest beside them. An
/// old one is removed before any file is replaced. No part, no masks. Fails if rasterize does, for
/// times beyond the mesh, and if the manifest cannot be written.
Result<GridFramesReport> writeGridFrames(const Input& input, const VoxelSeriesOptions& options,
                                         Observer& observer = nobody());

void describe(Members& members, const GridFramesReport& report);

}  // namespace t4d::tools
