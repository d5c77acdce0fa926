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

/// Pieces of a triangle are divided into four so many times, if need be: into 64.
constexpr int kDivisions = 3;

class Losses {
 public:
  Losses(const TriangleMesh& after, double tolerance)
      : tolerance_(tolerance), tree_(after), winding_(after) {}

  /// Points whose side is known, and how far the surface is from them.
  struct Ball {
    Point3 middle;
    double radius;
    bool isInside;
  };
  using Known = std::vector<Ball>;

  /// How far a triangle reaches out of the solid; 0 if that is within the tolerance. Its corners
  /// and the middles of its pieces are looked at, and added to what is known.
  double of(const PointsOfTriangle& corners, Known& known) const {
    const Point3 middle = middleOf(corners);
    const Nearest near = tree_.nearest(middle);
    if (isWithin(tolerance_, near, corners)) return 0;
    double farthest = 0;
    for (const Point3& corner : corners) {
      const Nearest found = nearestUnless(near.triangle, corner);
      if (isBeyond(found, farthest) && !isInside(corner, found, known)) farthest = found.distance;
    }
    look(corners, middle, near, kDivisions, false, known, farthest);
    return farthest;
  }

 private:
  using Nearest = measure::TriangleTree::Nearest;

  static Point3 middleOf(const PointsOfTriangle& corners) {
    return (corners[0] + corners[1] + corners[2]) / 3;
  }

  /// Looks for points of a piece that are out farther than `farthest`. `near` is nearest to its
  /// middle.
  void look(const PointsOfTriangle& corners, const Point3& middle, const Nearest& near,
            int divisions, bool isOutside, Known& known, double& farthest) const {
    if (isWithin(std::max(tolerance_, farthest), near, corners)) return;
    double radius = 0;
    for (const Point3& corner : corners) radius = std::max(radius, (corner - middle).stableNorm());
    // Farther from the surface than from its own points, a piece is on one side of it.
    const bool isApart = near.distance > radius;
    bool middleIsOut = isOutside;
    if (!isOutside && (isApart || isBeyond(near, farthest))) {
      middleIsOut = !isInside(middle, near, known);
      if (isApart && !middleIsOut) return;
      isOutside = isApart;
    }
    if (middleIsOut && isBeyond(near, farthest)) farthest = near.distance;
    if (divisions == 0) return;
    const PointsOfTriangle between = {0.5 * corners[1] + 0.5 * corners[2],
                                      0.5 * corners[2] + 0.5 * corners[0],
                                      0.5 * corners[0] + 0.5 * corners[1]};
    look(between, middle, near, divisions - 1, isOutside, known, farthest);
    for (int i = 0; i < 3; ++i) {
      PointsOfTriangle part = between;
      part[i] = corners[i];
      const Point3 itsMiddle = middleOf(part);
      look(part, itsMiddle, nearestUnless(near.triangle, itsMiddle), divisions - 1, isOutside,
           known, farthest);
    }
  }

  bool isBeyond(const Nearest& near, double farthest) const {
    return near.distance > std::max(tolerance_, farthest);
  }

  /// Whether a triangle is within a distance of one that is nearest to its middle. The distance
  /// from that is convex: no point is farther than the farthest corner.
  bool isWithin(double distance, const Nearest& near, const PointsOfTriangle& corners) const {
    return std::ranges::all_of(corners, [&](const Point3& corner) {
      return tree_.distanceTo(near.triangle, corner) <= distance;
    });
  }

  /// The triangle nearest to a point, which may be this one.
  Nearest nearestUnless(std::uint32_t triangle, const Point3& point) const {
    const Nearest known{triangle, tree_.distanceTo(triangle, point)};
    const Nearest found = tree_.nearest(point, known.distance);
    return found.distance < known.distance ? found : known;
  }

  /// Balls that the surface does not reach are on one side of it, and on the same if they meet.
  bool isInside(const Point3& point, const Nearest& near, Known& known) const {
    constexpr double kRounded = 1 - 1e-9;
    constexpr std::size_t kLooked = 100;
    std::size_t left = kLooked;
    for (auto ball = known.rbegin(); ball != known.rend() && left > 0; ++ball, --left) {
      const double reach = kRounded * (ball->radius + near.distance);
      if ((point - ball->middle).squaredNorm() >= reach * reach) continue;
      known.push_back({point, near.distance, ball->isInside});
      return known.back().isInside;
    }
    known.push_back({point, near.distance, winding_.at(point) > 0.5});
    return known.back().isInside;
  }

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
  constexpr std::size_t kAtOnce = 256;
  model::forRanges(0, triangles.size(), kAtOnce, [&](std::size_t begin, std::size_t end) {
    Losses::Known known;
    for (std::size_t i = begin; i < end; ++i) {
      const auto& [a, b, c] = triangles[i];
      out[i] = losses.of({before.vertices[a], before.vertices[b], before.vertices[c]}, known);
    }
  });
  LostSurface lost;
  lost.triangles = static_cast<std::uint64_t>(
      std::ranges::count_if(out, [](double distance) { return distance > 0; }));
  lost.distance = std::ranges::max(out);
  return lost;
}

}  // namespace t4d::edit
