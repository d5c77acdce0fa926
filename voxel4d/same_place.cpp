#include "voxel4d/same_place.h"

#include <algorithm>

namespace t4d::voxel4d {

double voxelsApart(const model::Affine3x4& a, const model::Affine3x4& b, const Eigen::Vector3d& low,
                   const Eigen::Vector3d& high) {
  const model::Affine3x4 difference = b - a;
  double farthest = 0;
  for (unsigned corner = 0; corner < 8; ++corner) {
    Eigen::Vector3d point;
    for (int axis = 0; axis < 3; ++axis) {
      point[axis] = (corner >> unsigned(axis) & 1U) != 0 ? high[axis] : low[axis];
    }
    const Eigen::Vector3d apart = difference.leftCols<3>() * point + difference.col(3);
    farthest = std::max(farthest, apart.norm());
  }
  return farthest / a.leftCols<3>().colwise().norm().minCoeff();
}

}  // namespace t4d::voxel4d
