#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "t4d/frames.h"

namespace t4d::voxel4d {

/// A scalar field over space and time, negative inside.
using FieldFunction = std::function<double(const model::Point3& point, double time)>;

struct SampleOptions {
  /// Blocks keep their values if one is below this or if they have points on both sides; in all
  /// other blocks the field is plus or minus this. In units of the field; 0 means 3 voxels.
  double band = 0;
  /// The field's Lipschitz constant: 1 for distances. One sample then suffices for cubes of blocks
  /// that cannot be near the surface. 0 if it is unknown; every point of the box is then sampled.
  double slope = 0;
  bool asFloat = false;  ///< store values as float, as most grids do
  bool mask = false;     ///< store no values
};

/// Frames sampled from a function at the lattice points within `box` (length units); all other
/// points are outside. `field` is called from several threads.
std::unique_ptr<FrameSource> sampledFrames(FieldFunction field, const Lattice& lattice,
                                           const model::Bounds3& box, std::vector<double> times,
                                           const SampleOptions& options = {});

}  // namespace t4d::voxel4d
