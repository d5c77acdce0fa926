#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "model/part.h"
#include "model/slab.h"
#include "voxel4d/frame.h"
#include "voxel4d/lost_part.h"
#include "voxel4d/moving_solid.h"

namespace t4d::voxel4d {

struct VoxelizeOptions {
  /// In length units. Lattice points are its multiples, so the origin is one of them.
  double voxelSize = 1;
  /// Store only which points are strictly inside (see occupancy.h), instead of the distance from
  /// the surface in a band of three voxels on either side.
  bool mask = false;
  /// The share of the frames that is written, under the names that they have in the whole series.
  /// What is inside in the frame after them is looked at, too: for the parts that are lost.
  model::Part part = {};
  /// The places of errors about each frame of voxelFrames, such as its file; without them, its
  /// number.
  std::vector<Place> places = {};
};

/// The solid at each of `times`, computed when its frame is requested. Fails if checkVoxelizable or
/// `solid` does.
std::unique_ptr<FrameSource> voxelFrames(SolidAtTime solid, std::vector<double> times,
                                         const VoxelizeOptions& options);

struct VoxelSeries {
  std::uint64_t frames = 0;
  std::uint64_t bytes = 0;             ///< of all files
  std::uint64_t insidePoints = 0;      ///< of all frames
  std::uint64_t emptyFrames = 0;       ///< without inside points
  std::uint64_t mostActiveVoxels = 0;  ///< in any one frame
  struct File {
    std::string name = {};  ///< beside the others
    std::uint64_t bytes = 0;
  };
  std::vector<File> files = {};  ///< of the frames, in their order
  LostParts partsLost = {};
};

/// Writes the frames of voxelFrames into `folder` (created if missing) as frame_0000.vdb, ...:
/// level sets named "surface", or bool grids named "inside" whose true values are active. The
/// metadata `t4d_time` of each is its time.
///
/// The series appears completely or not at all: files are renamed after all have been written.
/// Before that `beforeRenaming`, if there is one, can remove what described a series of these
/// names. Fails if voxelFrames or it does, or if the folder has other .vdb files, which would be
/// taken for frames of this series.
Result<VoxelSeries> writeVoxelFrames(const SolidAtTime& solid, const std::vector<double>& times,
                                     const VoxelizeOptions& options,
                                     const std::filesystem::path& folder,
                                     const model::Progress& progress = {},
                                     const std::function<Result<void>()>& beforeRenaming = {});

}  // namespace t4d::voxel4d
