#include "t4d/measure/missed_point.h"

#include <algorithm>
#include <cmath>

namespace t4d::measure {
namespace {

using model::Point3;

/// Whether a point of the cube about `point`, or of those next to it, is inside. `around` is 0 for
/// the corners of the cube, and 1 for those of its neighbours too.
bool hasInside(const VisitLattice& visits, const Point3& point, std::uint32_t around) {
  LatticeIndex low{};
  LatticeIndex high{};
  for (int axis = 0; axis < 3; ++axis) {
    const std::uint32_t above = visits.lattice().firstFrom(axis, point[axis]);
    const auto last = static_cast<std::uint32_t>(visits.lattice().at[axis].size() - 1);
    low[axis] = above - std::min(above, 1 + around);
    high[axis] = std::min(last, above + around);
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

}  // namespace

std::optional<Point3> missedPoint(const model::TriangleMesh& silhouette,
                                  const VisitLattice& visits) {
  const double spacing = visits.lattice().spacing;
  for (const auto& [i, j, k] : silhouette.triangles) {
    const Point3& a = silhouette.vertices[i];
    const Point3 u = silhouette.vertices[j] - a;
    const Point3 v = silhouette.vertices[k] - a;
    const auto stepsAlong = [&](const Point3& side) {
      return std::max(1, static_cast<int>(std::ceil(side.norm() / spacing)));
    };
    const int steps = stepsAlong(u);
    const int others = std::max(stepsAlong(v), stepsAlong(v - u));
    for (int p = 0; p <= steps; ++p) {
      const double s = p / double(steps);
      const int rows = std::max(1, static_cast<int>(std::ceil((1 - s) * others)));
      for (int q = 0; q <= rows; ++q) {
        const Point3 point = a + s * u + q / double(rows) * (1 - s) * v;
        if (!hasInside(visits, point, 0) && !hasInside(visits, point, 1)) return point;
      }
    }
  }
  return std::nullopt;
}

}  // namespace t4d::measure
