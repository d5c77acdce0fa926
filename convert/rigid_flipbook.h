#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "convert/flipbook.h"
#include "model/body.h"
#include "model/layer_pose.h"

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

/// Writes a flipbook with one mesh per body, moved by poses. The file is small, and plays smoothly.
/// `times` determines only the first and last time to show and how long it plays: as long as
/// writeFlipbook with these frames. `options.detail` is not used, and colours and attributes are
/// those of the first time (addFirstLooks). Fails if writeFlipbook does, and if a body is not
/// rigid.
Result<FrameSlicesReport> writeRigidFlipbook(std::span<const model::Body> bodies,
                                             std::span<const double> times,
                                             const std::filesystem::path& path,
                                             const FlipbookOptions& options = {},
                                             const model::Progress& progress = {});

}  // namespace t4d::convert
