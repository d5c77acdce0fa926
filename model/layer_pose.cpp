#include <cstring>

#include "t4d/mesh.h"

namespace t4d::model {

Point3 posed(const Affine3x4& pose, const Point3& point) {
  Point3 moved;
  for (int row = 0; row < 3; ++row) {
    const double turned =
        (pose(row, 0) * point[0] + pose(row, 1) * point[1]) + pose(row, 2) * point[2];
    moved[row] = turned + pose(row, 3);
  }
  return moved;
}

Point3 LayerPose::at(std::size_t vertex) const {
  const auto rounded = [&](const Point3& point) -> Point3 {
    return float32 ? point.cast<float>().cast<double>().eval() : point;
  };
  return rounded(posed(pose, rounded((*reference)[vertex])));
}

bool LayerPose::gives(std::span<const Point4> layer) const {
  if (!reference || reference->size() != layer.size()) return false;
  for (std::size_t i = 0; i < layer.size(); ++i) {
    const Point3 position = at(i);
    if (std::memcmp(position.data(), layer[i].data(), sizeof position) != 0) return false;
  }
  return true;
}

}  // namespace t4d::model
