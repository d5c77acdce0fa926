#pragma once

#include <filesystem>
#include <memory>
#include <span>

#include "t4d/frames.h"
#include "voxel4d/velocity.h"

namespace t4d::voxel4d {

/// The velocities of `frames`, from volumes that have one for each of their samples: three files of
/// the components along x, y and z of space. They are in length units per time unit; where all
/// three are 0, the velocity is not known. `options` are those that the frames were opened with.
/// Three frames of samples are in memory.
///
/// Fails for volumes that openVolumeFrames refuses, that have other sizes, or that lie elsewhere.
Result<std::unique_ptr<VelocitySource>> openVolumeVelocity(
    std::span<const std::filesystem::path> files, const VolumeOptions& options,
    const VolumeFrames& frames);

}  // namespace t4d::voxel4d
