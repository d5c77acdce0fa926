#pragma once

#include <openvdb/openvdb.h>

#include "t4d/error.h"
#include "voxel4d/velocity.h"

namespace t4d::voxel4d {

/// Signed distances (in voxels, negative inside) and velocities about the surface of a frame, as
/// far as it may move and kWidth voxels more.
class SurfaceBand {
 public:
  static constexpr int kWidth = 4;

  /// Makes the band for motion over a time of at most `duration`. Fails as advectedFrames says;
  /// errors are those of the velocities.
  static Result<SurfaceBand> of(const Frame& frame, const VelocityField& velocity, double duration);

  /// The time that the band suffices for.
  double duration() const { return duration_; }
  /// The change of the values of the frame from voxel to voxel across the surface; 0 without one.
  double slope() const { return slope_; }
  /// The distances at the time of the frame plus `time`, which may be negative.
  openvdb::FloatGrid::Ptr carried(double time) const;

 private:
  openvdb::FloatGrid::Ptr distance_;
  openvdb::Vec3SGrid::Ptr velocity_;  // voxels per time unit
  double duration_ = 0;
  double speed_ = 0;
  double slope_ = 0;
};

}  // namespace t4d::voxel4d
