#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "t4d/mesh.h"
#include "t4d/motion.h"
#include "t4d/surface.h"

/// How close in time the frames of a motion must be. Between two frames the voxel method can only
/// blend: a part that moves by more than a voxel in between comes out too thin.
namespace t4d::voxel4d {

/// The maximum number of frames of a series.
inline constexpr std::size_t kMaxFrames = 1'000'000;

/// The times of frames: `count` evenly spaced ones; or one every `step` from the first time, to the
/// last time or for `count` frames.
struct FrameTimes {
  std::optional<std::uint64_t> count = {};
  std::optional<double> step = {};
};

/// Computes these times (model::evenTimes, model::steppedTimes). Fails for fewer than two or more
/// than kMaxFrames, for a step that is not positive, for more steps than fit, and for times that
/// are too close to represent.
Result<std::vector<double>> frameTimes(const model::TimeSpan& span, const FrameTimes& when);

/// Fails unless `times`, given for `frames` frames, are as many, increase, and are no larger than
/// model::kLargestCoordinate.
Result<void> checkFrameTimes(std::span<const double> times, std::size_t frames);

/// The maximum speed, over all times of `motion`, of any point of the convex hull of `mesh`'s
/// vertices, in length units per time unit; up to rounding. 0 without vertices. Takes time
/// proportional to vertices times segments at most.
double maxSpeed(const model::TriangleMesh& mesh, const model::Motion& motion);

/// The largest difference between two consecutive elements of `times`, which must increase.
/// Multiplied by `speed`, it bounds how far a point can move between two frames.
double largestGap(std::span<const double> times);

/// The number of evenly spaced frames over `span`, at least two, between which no point moves by
/// more than `distance` > 0 (length units) if its speed is at most `speed`: a path is no longer
/// than speed times time, and a displacement no longer than the path. Fails if that takes more than
/// kMaxFrames.
Result<std::uint64_t> framesWithin(double distance, double speed, const model::TimeSpan& span);

}  // namespace t4d::voxel4d
