#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "edit/mend_steps.h"
#include "measure/triangle_tree.h"
#include "measure/winding_number.h"
#include "model/parallel.h"

namespace t4d::edit {
namespace {

using model::Point3;
using model::Triangle;
using model::TriangleMesh;
using PointsOfTriangle = std::array<Point3, 3>;

/// Points of a triangle are looked at on a lattice that divides its sides into so many parts.
constexpr int kParts = 8;

class Losses {
 public:
  Losses(const TriangleMesh& after, double tolerance)
      : tolerance_(tolerance), tree_(after), winding_(after) {}

  /// How far a triangle reaches out of the solid; 0 if that is within the tolerance.
  double of(const PointsOfTriangle& corners) const {
    std::array<measure::TriangleTree::Nearest, 3> nearest;
    for (int i = 0; i < 3; ++i) nearest[i] = tree_.nearest(corners[i]);
    // The distance from one triangle is convex: no point is farther than the farthest corner.
    if (std::ranges::all_of(corners, [&](const Point3& corner) {
          return tree_.distanceTo(nearest[0].triangle, corner) <= tolerance_;
        })) {
      return 0;
    }
    double longest = 0;
    for (int i = 0; i < 3; ++i) {
      longest = std::max(longest, (corners[(i + 1) % 3] - corners[i]).stableNorm());
    }
    if (isInside(corners[0]) && nearest[0].distance > longest) return 0;
    double farthest = 0;
    for (int i = 0; i <= kParts; ++i) {
      for (int k = 0; i + k <= kParts; ++k) {
        const Point3 point =
            (i * corners[0] + k * corners[1] + (kParts - i - k) * corners[2]) / kParts;
        const double distance = tree_.nearest(point).distance;
        if (distance > std::max(farthest, tolerance_) && !isInside(point)) farthest = distance;
      }
    }
    return farthest;
  }

 private:
  bool isInside(const Point3& point) const { return winding_.at(point) > 0.5; }

  double tolerance_;
  measure::TriangleTree tree_;
  measure::WindingNumber winding_;
};

}  // namespace

LostSurface lostSurface(const TriangleMesh& before, const TriangleMesh& after, double tolerance) {
  const Losses losses(after, tolerance);
  // One of the triangles with the same corners is kept.
  std::vector<Triangle> triangles = before.triangles;
  for (Triangle& triangle : triangles) std::ranges::sort(triangle);
  std::ranges::sort(triangles);
  const auto again = std::ranges::unique(triangles);
  triangles.erase(again.begin(), again.end());
  std::vector<double> out(triangles.size());
  model::forEach(triangles.size(), [&](std::size_t i) {
    const auto& [a, b, c] = triangles[i];
    out[i] = losses.of({before.vertices[a], before.vertices[b], before.vertices[c]});
  });
  LostSurface lost;
  lost.triangles = static_cast<std::uint64_t>(
      std::ranges::count_if(out, [](double distance) { return distance > 0; }));
  lost.distance = std::ranges::max(out);
  return lost;
}

}  // namespace t4d::edit
