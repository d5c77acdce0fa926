#include "measure/missed_point.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <vector>

#include "model/parallel.h"

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

/// Looks for points that are missed. Most points are in a cube that others have been in: the last
/// cubes that were near the inside are remembered.
class MissedPoints {
 public:
  explicit MissedPoints(const VisitLattice& visits) : visits_(visits), near_(kRemembered) {}

  double spacing() const { return visits_.lattice().spacing; }

  /// Safe to call from several threads at once.
  bool isMissed(const Point3& point) const {
    const SpaceLattice& lattice = visits_.lattice();
    LatticeIndex above{};
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      above[axis] = lattice.firstFrom(axis, point[axis]);
      key = key * (lattice.at[axis].size() + 1) + above[axis];
    }
    std::atomic<std::uint64_t>& remembered = near_[key % kRemembered];
    if (remembered.load(std::memory_order_relaxed) == key + 1) return false;
    if (!hasInside(visits_, above, 0) && !hasInside(visits_, above, 1)) return true;
    remembered.store(key + 1, std::memory_order_relaxed);
    return false;
  }

 private:
  static constexpr std::size_t kRemembered = (std::size_t{1} << 18U) - 5;  // a prime

  const VisitLattice& visits_;
  mutable std::vector<std::atomic<std::uint64_t>> near_;  // keys + 1
};

/// The first of the points that `pointOf` gives for numbers below `count`.
template <class PointOf>
std::optional<Point3> firstMissed(std::size_t count, const PointOf& pointOf) {
  std::atomic<std::size_t> first = count;
  model::forEach(count, [&](std::size_t i) {
    if (i >= first || !pointOf(i)) return;
    std::size_t before = first;
    while (i < before && !first.compare_exchange_weak(before, i)) {
    }
  });
  return first < count ? pointOf(first) : std::nullopt;
}

/// The first missed one of the points of a triangle that are about a spacing apart. A triangle that
/// is no larger has none but its corners, which are left out.
std::optional<Point3> missedWithin(const model::TriangleMesh& silhouette, std::size_t triangle,
                                   const MissedPoints& points) {
  const auto& [i, j, k] = silhouette.triangles[triangle];
  const Point3& a = silhouette.vertices[i];
  const Point3 u = silhouette.vertices[j] - a;
  const Point3 v = silhouette.vertices[k] - a;
  const auto stepsAlong = [&](const Point3& side) {
    return std::max(1, static_cast<int>(std::ceil(side.norm() / points.spacing())));
  };
  const int steps = stepsAlong(u);
  const int others = std::max(stepsAlong(v), stepsAlong(v - u));
  if (steps == 1 && others == 1) return std::nullopt;
  for (int p = 0; p <= steps; ++p) {
    const double s = p / double(steps);
    const int rows = std::max(1, static_cast<int>(std::ceil((1 - s) * others)));
    for (int q = 0; q <= rows; ++q) {
      const Point3 point = a + s * u + q / double(rows) * (1 - s) * v;
      if (points.isMissed(point)) return point;
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<Point3> missedPoint(const model::TriangleMesh& silhouette,
                                  const VisitLattice& visits) {
  const MissedPoints points(visits);
  const auto corner = firstMissed(silhouette.vertices.size(), [&](std::size_t i) {
    const Point3& vertex = silhouette.vertices[i];
    return points.isMissed(vertex) ? std::optional(vertex) : std::nullopt;
  });
  if (corner) return corner;
  return firstMissed(silhouette.triangles.size(),
                     [&](std::size_t i) { return missedWithin(silhouette, i, points); });
}

}  // namespace t4d::measure
