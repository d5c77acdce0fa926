#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>

#include "t4d/surface.h"

/// Integer coordinates, in which it is decided exactly what triangle a line along an axis crosses.
/// Only the sources of this folder include it.
namespace t4d::voxel4d {

__extension__ typedef __int128 Int128;  // NOLINT(modernize-use-using)

/// Coordinates in units of a power of two of a voxel: below 2^60, so that the cross product of two
/// differences fits in 128 bits.
using FixedPoint = std::array<std::int64_t, 3>;

class FixedScale {
 public:
  /// The points are in voxels.
  FixedScale(std::span<const model::Point3> points, std::span<const model::Triangle> triangles) {
    for (const model::Triangle& triangle : triangles) {
      for (const std::uint32_t vertex : triangle) {
        largest_ = std::max(largest_, points[vertex].cwiseAbs().maxCoeff());
      }
    }
    constexpr int kBits = 60;
    shift_ = kBits - 1 - std::ilogb(largest_);
  }

  /// The largest coordinate, at least 1.
  double largest() const { return largest_; }
  std::int64_t unit() const { return std::int64_t{1} << shift_; }  ///< one voxel
  FixedPoint fixed(const model::Point3& point) const {
    const auto coordinate = [&](int axis) { return std::llround(std::ldexp(point[axis], shift_)); };
    return {coordinate(0), coordinate(1), coordinate(2)};
  }

 private:
  double largest_ = 1;
  int shift_ = 0;
};

/// A triangle that is crossed by the line through a point along the third axis.
struct LineCrossing {
  std::array<double, 3> weights;  ///< of its corners at the crossing; their sum is 1
  bool up;                        ///< whether its corners are counter-clockwise about the axis
};

/// Whether the line through `at`, along the axis that follows `u` and `v`, crosses a triangle. If
/// it meets an edge or a corner, it counts as shifted by (e, e^2) along u and v, with e
/// infinitesimal: so it crosses a closed surface as often in either direction.
inline std::optional<LineCrossing> crossingOf(const std::array<FixedPoint, 3>& triangle,
                                              const FixedPoint& at, int u, int v) {
  const auto cross = [&](const FixedPoint& from, const FixedPoint& to, const FixedPoint& point) {
    return static_cast<Int128>(to[u] - from[u]) * (point[v] - from[v]) -
           static_cast<Int128>(to[v] - from[v]) * (point[u] - from[u]);
  };
  const auto& [a, b, c] = triangle;
  const Int128 area = cross(a, b, c);
  if (area == 0) return std::nullopt;
  const bool up = area > 0;
  const auto isLeft = [&](const FixedPoint& from, const FixedPoint& to, Int128 side) {
    if (side != 0) return side > 0;
    return to[v] != from[v] ? to[v] < from[v] : to[u] > from[u];
  };
  const Int128 ab = cross(a, b, at);
  const Int128 bc = cross(b, c, at);
  const Int128 ca = cross(c, a, at);
  if (isLeft(a, b, ab) != up || isLeft(b, c, bc) != up || isLeft(c, a, ca) != up) {
    return std::nullopt;
  }
  const double inverse = 1 / static_cast<double>(area);
  return LineCrossing{{static_cast<double>(bc) * inverse, static_cast<double>(ca) * inverse,
                       static_cast<double>(ab) * inverse},
                      up};
}

}  // namespace t4d::voxel4d
