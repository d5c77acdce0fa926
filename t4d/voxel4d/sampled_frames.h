#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "t4d/voxel4d/frame.h"

namespace t4d::voxel4d {

/// A scalar field over space and time, negative inside.
using FieldFunction = std::function<double(const model::Point3& point, double time)>;

struct SampleOptions {
  /// Blocks that have a value below this, or points on both sides, keep their values; in all others
  /// the field is taken for plus or minus this. In units of the field; 0 means 3 voxels.
  double band = 0;
  /// What a difference of the field is at most, for a distance of one: 1 for distances. Cubes of
  /// blocks that cannot be near the surface are then settled by one sample. 0: not known, every
  /// point of the box is sampled.
  double slope = 0;
  bool asFloat = false;  ///< keep values as float, as most grids do
  bool mask = false;     ///< keep no values
};

/// Frames sampled from a function at lattice points within `box` (length units); outside of it is
/// outside. `field` is called from several threads.
std::unique_ptr<FrameSource> sampledFrames(FieldFunction field, const Lattice& lattice,
                                           const model::Bounds3& box, std::vector<double> times,
                                           const SampleOptions& options = {});

}  // namespace t4d::voxel4d
