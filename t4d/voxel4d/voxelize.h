#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "t4d/model/motion.h"
#include "t4d/model/slab.h"
#include "t4d/model/times.h"
#include "t4d/model/triangle_mesh.h"
#include "t4d/voxel4d/frame.h"

namespace t4d::voxel4d {

/// The maximum number of frames of a series.
inline constexpr std::size_t kMaxFrames = 1'000'000;

/// The times of frames: `count` of them evenly spaced; or one every `step` from the first time on,
/// as many as fit, or the first `count` of these.
struct FrameTimes {
  std::optional<std::uint64_t> count = {};
  std::optional<double> step = {};
};

/// Computes these times (model::evenTimes, model::steppedTimes). Fails for fewer than two or more
/// than kMaxFrames, for a step that is not positive, for more steps than fit, and for times that
/// are too close to represent.
Result<std::vector<double>> frameTimes(const model::TimeSpan& span, const FrameTimes& when);

/// A solid as a function of time: closed and facing outward; empty if there is none.
using SolidAtTime = std::function<Result<model::TriangleMesh>(double time)>;

/// `mesh` in the poses of `motion`.
SolidAtTime movingSolid(model::TriangleMesh mesh, model::Motion motion);

struct VoxelizeOptions {
  /// In length units. Lattice points are its multiples, so the origin is one of them.
  double voxelSize = 1;
  /// Store only which points are strictly inside (see occupancy.h), instead of the distance from
  /// the surface in a band of three voxels on either side.
  bool mask = false;
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
