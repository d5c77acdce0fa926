#pragma once

#include <algorithm>
#include <array>
#include <span>

#include "t4d/model/slab.h"

namespace t4d::edit {

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

inline std::array<model::Point4, 4> cornersOf(std::span<const model::Point4> vertices,
                                              const model::Cell& cell) {
  return {vertices[cell[0]], vertices[cell[1]], vertices[cell[2]], vertices[cell[3]]};
}

/// The outward normal of a cell with these corners, six times as long as its volume.
inline Eigen::Vector4d cellNormal(const std::array<model::Point4, 4>& corners) {
  return crossProduct(corners[1] - corners[0], corners[2] - corners[0], corners[3] - corners[0]);
}

/// The square of measure::CellQuality::height, the smallest height of a tetrahedron divided by its
/// longest edge; `normal` is that of cellNormal. 2/3 for a regular one, 0 for a flat one.
inline double squaredHeight(const std::array<model::Point4, 4>& corners,
                            const Eigen::Vector4d& normal) {
  const auto edge = [&](int i, int j) { return (corners[i] - corners[j]).squaredNorm(); };
  const double ab = edge(0, 1), ac = edge(0, 2), ad = edge(0, 3);
  const double bc = edge(1, 2), bd = edge(1, 3), cd = edge(2, 3);
  // 16 times the square of the area of a triangle (Heron).
  const auto area = [](double p, double q, double r) {
    return 4 * p * q - (p + q - r) * (p + q - r);
  };
  const double largest =
      std::max({area(ab, ac, bc), area(ab, ad, bd), area(ac, ad, cd), area(bc, bd, cd)});
  const double longest = std::max({ab, ac, ad, bc, bd, cd});
  const double scale = largest * longest;
  return scale > 0 ? 4 * normal.squaredNorm() / scale : 0;
}

}  // namespace t4d::edit
