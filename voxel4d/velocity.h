#pragma once

#include <functional>
#include <optional>
#include <string>

#include "t4d/error.h"
#include "t4d/frames.h"

namespace t4d::voxel4d {

/// The motion of matter at the time of a frame.
struct VelocityField {
  /// The velocity at a lattice point of the frames, in lattice points per time unit; nothing where
  /// it is not known. Called from several threads.
  std::function<std::optional<Eigen::Vector3d>(const Coord& point)> at;
  bool moves = false;  ///< whether a velocity is known anywhere
};

/// Provides the velocities of frames.
class VelocitySource {
 public:
  virtual ~VelocitySource() = default;
  /// The place of errors about the velocities of a frame: their file and grid.
  virtual Place placeOf(std::size_t index) const = 0;
  /// Called once for each frame, in order. The field keeps what it needs.
  virtual Result<VelocityField> field(std::size_t index) = 0;
};

}  // namespace t4d::voxel4d
