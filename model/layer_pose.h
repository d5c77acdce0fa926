#pragma once

#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "model/geometry.h"

namespace t4d::model {

/// The 3x4 matrix (rotation | translation) of an affine map.
using Affine3x4 = Eigen::Matrix<double, 3, 4>;

/// x = ((m00 qx + m01 qy) + m02 qz) + m03, and y and z by the next rows, each operation in double
/// precision. All code that computes or checks a posed layer calls this function, so it has the
/// same bits wherever it is computed.
Point3 posed(const Affine3x4& pose, const Point3& point);

/// The vertices of a layer as those of a reference, moved by a pose. A solid that keeps its shape
/// is stored in this way.
struct LayerPose {
  std::shared_ptr<const std::vector<Point3>> reference = {};
  Affine3x4 pose = Affine3x4::Identity();
  /// The reference is rounded to float32 first, and so is the result.
  bool float32 = false;

  Point3 at(std::size_t vertex) const;
  /// Whether the layer has exactly the positions of this pose; times are ignored.
  bool gives(std::span<const Point4> layer) const;
};

}  // namespace t4d::model
