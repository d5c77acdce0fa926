#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "t4d/convert/flipbook.h"
#include "t4d/model/body.h"
#include "t4d/model/layer_pose.h"

namespace t4d::convert {

/// A solid that keeps its shape: its surface, and where it is at each layer.
struct RigidMotion {
  model::TriangleMesh solid;
  struct Layer {
    double time = 0;
    model::Affine3x4 pose;  ///< a rotation and a translation of `solid`
  };
  std::vector<Layer> layers;
  /// Between two layers the solid is turned about `center` at a constant speed, and that moves
  /// straight. No point of it is then further than this from the exact slice, nor the other way
  /// round: from the light slice, whose vertices move on chords, it is off by at most
  /// r (1 - cos(theta / 2)) in a step that turns by theta, where r is the largest distance of a
  /// vertex from the axis through `center`; the distance of that from the exact one is added.
  model::Point3 center = model::Point3::Zero();
  double distance = 0;
};

/// Reads all slabs. Fails, saying why, unless all are prisms (prisms.h) of the same triangles
/// without a gap in time, and each layer is a rigid pose of one reference (Slab::upperPose).
Result<RigidMotion> rigidMotionOf(const model::Source& source,
                                  const model::Progress& progress = {});

/// A flipbook whose bodies are one mesh each, moved by poses: `times` says only the first and last
/// time to show and how long it plays, as writeFlipbook does with a frame for each. So the file has
/// kilobytes, and plays smoothly. `options.detail` is not used, nor are attributes, and colours
/// are those of the first time. Fails as writeFlipbook, and if a body is not rigid.
Result<FrameSlicesReport> writeRigidFlipbook(std::span<const model::Body> bodies,
                                             std::span<const double> times,
                                             const std::filesystem::path& path,
                                             const FlipbookOptions& options = {},
                                             const model::Progress& progress = {});

}  // namespace t4d::convert
