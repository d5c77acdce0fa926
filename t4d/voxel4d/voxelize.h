#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "t4d/model/motion.h"
#include "t4d/model/slab.h"
#include "t4d/model/times.h"
#include "t4d/model/triangle_mesh.h"
#include "t4d/voxel4d/frame.h"

namespace t4d::voxel4d {

/// More frames than this are refused.
inline constexpr std::size_t kMaxFrames = 1'000'000;

/// When the frames of a motion are: `count` of them evenly over it; or every `step` from its first
/// time on, as many as fit, or the first `count` of these.
struct FrameTimes {
  std::optional<std::uint64_t> count;
  std::optional<double> step;
};

/// Those times (model::evenTimes, model::steppedTimes). Fails for fewer than two or more than
/// kMaxFrames, for a step that is not positive, for a count of steps that do not fit, and for times
/// that are too close to represent.
Result<std::vector<double>> frameTimes(const model::TimeSpan& span, const FrameTimes& when);

/// A solid as a function of time: closed, facing outward; empty where there is none.
using SolidAtTime = std::function<Result<model::TriangleMesh>(double time)>;

/// `mesh` in the poses of `motion`.
SolidAtTime movingSolid(model::TriangleMesh mesh, model::Motion motion);

struct VoxelizeOptions {
  /// Length units. The lattice is all multiples of it: the origin is a lattice point.
  double voxelSize = 1;
  /// Only which points are strictly inside (see occupancy.h), instead of the distance from the
  /// surface in a band of three voxels on either side.
  bool mask = false;
};

/// The solid at each of `times`, made when its frame is asked for. Errors are those of
/// checkVoxelizable, and those of `solid`.
std::unique_ptr<FrameSource> voxelFrames(SolidAtTime solid, std::vector<double> times,
                                         const VoxelizeOptions& options);

struct VoxelSeries {
  std::uint64_t frames = 0;
  std::uint64_t bytes = 0;             ///< of all files
  std::uint64_t insidePoints = 0;      ///< of all frames
  std::uint64_t mostActiveVoxels = 0;  ///< of the frame that has most
};

/// Writes the frames of voxelFrames into `folder` (made where it is missing) as frame_0000.vdb,
/// ...: level sets named "surface", or bool grids named "inside", whose true values are active.
/// Each has its time as metadata `t4d_time`.
///
/// The series appears whole or not at all: files are written aside and renamed when all are done.
/// Refused: what voxelFrames refuses, and a folder with other .vdb files, which would pass for
/// frames of this series.
Result<VoxelSeries> writeVoxelFrames(const SolidAtTime& solid, const std::vector<double>& times,
                                     const VoxelizeOptions& options,
                                     const std::filesystem::path& folder,
                                     const model::Progress& progress = {});

}  // namespace t4d::voxel4d
