#pragma once

#include <cmath>
#include <optional>

#include <openvdb/math/Coord.h>
#include <openvdb/math/Vec3.h>

namespace t4d::voxel4d {

/// Interpolates between lattice points of which some are not known: the trilinear mean of those
/// about `point` for which `valueAt` returns a Value; nothing if there is none.
template <class Value, class ValueAt>
std::optional<Value> meanOfKnown(const openvdb::Vec3d& point, const ValueAt& valueAt) {
  const openvdb::Coord low = openvdb::Coord::floor(point);
  Value sum(0);
  double weights = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const openvdb::Coord at = low.offsetBy(corner & 1, corner >> 1 & 1, corner >> 2);
    double weight = 1;
    for (int axis = 0; axis < 3; ++axis) weight *= 1 - std::abs(point[axis] - at[axis]);
    if (!(weight > 0)) continue;
    const std::optional<Value> value = valueAt(at);
    if (!value) continue;
    sum += weight * *value;
    weights += weight;
  }
  if (!(weights > 0)) return std::nullopt;
  return sum / weights;
}

}  // namespace t4d::voxel4d
