#include "t4d/measure/missed_point.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include <tbb/parallel_for.h>

namespace t4d::measure {
namespace {

using model::Point3;

/// Whether a corner of the cube whose highest corner is `above` is inside; with `around` 1, of that
/// or those next to it.
bool hasInside(const VisitLattice& visits, const LatticeIndex& above, std::uint32_t around) {
  LatticeIndex low{};
  LatticeIndex high{};
  for (int axis = 0; axis < 3; ++axis) {
    const auto last = static_cast<std::uint32_t>(visits.lattice().at[axis].size() - 1);
    low[axis] = above[axis] - std::min(above[axis], 1 + around);
    high[axis] = std::min(last, above[axis] + around);
  }
  for (std::uint32_t x = low[0]; x <= high[0]; ++x) {
    for (std::uint32_t y = low[1]; y <= high[1]; ++y) {
      for (std::uint32_t z = low[2]; z <= high[2]; ++z) {
        if (visits.isInside({x, y, z})) return true;
      }
    }
  }
  return false;
}

bool isMissed(const VisitLattice& visits, const Point3& point) {
  LatticeIndex above{};
  for (int axis = 0; axis < 3; ++axis) {
    above[axis] = visits.lattice().firstFrom(axis, point[axis]);
  }
  return !hasInside(visits, above, 0) && !hasInside(visits, above, 1);
}

/// The first of the points that `pointOf` gives for numbers below `count`.
template <class PointOf>
std::optional<Point3> firstMissed(std::size_t count, const PointOf& pointOf) {
  std::atomic<std::size_t> first = count;
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    if (i >= first || !pointOf(i)) return;
    std::size_t before = first;
    while (i < before && !first.compare_exchange_weak(before, i)) {
    }
  });
  return first < count ? pointOf(first) : std::nullopt;
}

/// Of the points of a triangle that are about a spacing apart, the first that is missed. A triangle
/// that is no larger has none but its corners, which are left out.
std::optional<Point3> missedWithin(const model::TriangleMesh& silhouette, std::size_t triangle,
                                   const VisitLattice& visits) {
  const auto& [i, j, k] = silhouette.triangles[triangle];
  const Point3& a = silhouette.vertices[i];
  const Point3 u = silhouette.vertices[j] - a;
  const Point3 v = silhouette.vertices[k] - a;
  const auto stepsAlong = [&](const Point3& side) {
    return std::max(1, static_cast<int>(std::ceil(side.norm() / visits.lattice().spacing)));
  };
  const int steps = stepsAlong(u);
  const int others = std::max(stepsAlong(v), stepsAlong(v - u));
  if (steps == 1 && others == 1) return std::nullopt;
  for (int p = 0; p <= steps; ++p) {
    const double s = p / double(steps);
    const int rows = std::max(1, static_cast<int>(std::ceil((1 - s) * others)));
    for (int q = 0; q <= rows; ++q) {
      const Point3 point = a + s * u + q / double(rows) * (1 - s) * v;
      if (isMissed(visits, point)) return point;
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<Point3> missedPoint(const model::TriangleMesh& silhouette,
                                  const VisitLattice& visits) {
  const auto corner = firstMissed(silhouette.vertices.size(), [&](std::size_t i) {
    const Point3& vertex = silhouette.vertices[i];
    return isMissed(visits, vertex) ? std::optional(vertex) : std::nullopt;
  });
  if (corner) return corner;
  return firstMissed(silhouette.triangles.size(),
                     [&](std::size_t i) { return missedWithin(silhouette, i, visits); });
}

}  // namespace t4d::measure
