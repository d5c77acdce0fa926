#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "t4d/motion.h"
#include "t4d/surface.h"
#include "voxel4d/frame_spacing.h"

namespace t4d::tools {

/// The times of a motion's frames: as given by `when`, or otherwise enough that no point of `mesh`
/// moves by more than a voxel between two frames. Adds a notice if the frames of `when` are farther
/// apart. `where` of an error is `motionFile`.
Result<std::vector<double>> motionFrameTimes(const voxel4d::FrameTimes& when, double voxelSize,
                                             const model::TriangleMesh& mesh,
                                             const model::Motion& motion,
                                             const std::string& motionFile,
                                             std::vector<std::string>& notices);

/// That a point moves by more than a voxel between two of these frames, and how many frames would
/// keep it within one, if that many are possible; "" if none does.
std::string noticeOfGaps(std::span<const double> times, double speed, double voxelSize,
                         const Result<std::uint64_t>& enough);

}  // namespace t4d::tools
