#pragma once

#include <algorithm>
#include <array>
#include <span>

#include "t4d/mesh.h"

namespace t4d::edit {

inline std::array<model::Point4, 4> cornersOf(std::span<const model::Point4> vertices,
                                              const model::Cell& cell) {
  return {vertices[cell[0]], vertices[cell[1]], vertices[cell[2]], vertices[cell[3]]};
}

/// The square of measure::CellQuality::height, the smallest height of a tetrahedron divided by its
/// longest edge: 2/3 for a regular tetrahedron, 0 for a flat one. `normal` is that of
/// model::cellNormal.
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
