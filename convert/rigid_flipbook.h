#pragma once

#include <vector>

#include "t4d/convert.h"

namespace t4d::convert {

/// A solid that keeps its shape: its surface, and its pose at each layer.
struct RigidMotion {
  model::TriangleMesh solid;
  struct Layer {
    double time = 0;
    model::Affine3x4 pose;  ///< a rotation and a translation of `solid`
  };
  std::vector<Layer> layers;
  /// Between two layers the solid turns about `center` at a constant speed, and `center` moves
  /// along a straight line.
  model::Point3 center = model::Point3::Zero();
  /// A bound on the Hausdorff distance of the solid from the exact slice at the same time. From the
  /// light slice, whose vertices move along straight lines, it differs by at most
  /// r (1 - cos(theta / 2)) in a step that turns by theta, where r is the largest distance of a
  /// vertex from the axis through `center`. The distance of the light slice is added.
  double distance = 0;
};

/// Reads all slabs. Fails, with the reason, unless all consist of prisms (prisms.h) of the same
/// triangles without a gap in time, and each layer is a rigid pose of one reference
/// (Slab::upperPose).
Result<RigidMotion> rigidMotionOf(const model::Source& source,
                                  const model::Progress& progress = {});

}  // namespace t4d::convert
