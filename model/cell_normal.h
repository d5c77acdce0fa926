#pragma once

#include <array>

#include "t4d/mesh.h"

namespace t4d::model {

/// The vector m with m.x = det[x, u, v, w] for all x: perpendicular to the three, six times as long
/// as the volume of the tetrahedron that they span.
inline Eigen::Vector4d crossProduct(const Eigen::Vector4d& u, const Eigen::Vector4d& v,
                                    const Eigen::Vector4d& w) {
  const double xy = v[0] * w[1] - v[1] * w[0];
  const double xz = v[0] * w[2] - v[2] * w[0];
  const double xt = v[0] * w[3] - v[3] * w[0];
  const double yz = v[1] * w[2] - v[2] * w[1];
  const double yt = v[1] * w[3] - v[3] * w[1];
  const double zt = v[2] * w[3] - v[3] * w[2];
  return {u[1] * zt - u[2] * yt + u[3] * yz, -(u[0] * zt - u[2] * xt + u[3] * xz),
          u[0] * yt - u[1] * xt + u[3] * xy, -(u[0] * yz - u[1] * xz + u[2] * xy)};
}

/// The outward normal of a cell with these corners, six times as long as its volume.
inline Eigen::Vector4d cellNormal(const std::array<Point4, 4>& corners) {
  return crossProduct(corners[1] - corners[0], corners[2] - corners[0], corners[3] - corners[0]);
}

}  // namespace t4d::model
