#pragma once

#include <cstdint>
#include <memory>

#include "voxel4d/velocity.h"

namespace t4d::voxel4d {

/// No point moves by more voxels between two frames: the velocities would be damaged, or in other
/// units.
inline constexpr double kMostMotion = 32;

/// `frames`, and between every two of them `substeps` - 1 more, evenly spaced in time. One in
/// between is a blend of signed distances: those of both neighbours, carried to its time by their
/// velocities, weighted by nearness in time. So what moves goes on, and only what the velocities do
/// not explain fades. Frames themselves are not changed. Where a velocity is not known, it is that
/// of the nearest point of the surface. Two frames, their distances and velocities are in memory.
///
/// Requesting a frame fails, besides where a source does, for frames without values, for velocities
/// that move the surface by more than kMostMotion voxels between two frames, and for velocities of
/// which none is near the surface.
std::unique_ptr<FrameSource> advectedFrames(std::unique_ptr<FrameSource> frames,
                                            std::unique_ptr<VelocitySource> velocities,
                                            std::uint32_t substeps);

}  // namespace t4d::voxel4d
