#include <array>
#include <limits>
#include <optional>
#include <queue>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "measure/triangle_tree.h"
#include "model/unit_scale.h"
#include "t4d/check.h"

namespace t4d::measure {
namespace {

using model::Point3;
using model::TriangleMesh;

struct Corner {
  Point3 point;
  TriangleTree::Nearest nearest;
};

/// A part of a triangle, with an upper bound of its points' distance from the other mesh.
struct Piece {
  std::array<Corner, 3> corners;
  double atMost = 0;

  friend bool operator<(const Piece& a, const Piece& b) { return a.atMost < b.atMost; }
};

/// An upper bound of the distance of the points of a piece from one triangle of the other mesh.
double farthestFrom(std::uint32_t triangle, const std::array<Corner, 3>& corners,
                    const TriangleTree& other) {
  double farthest = 0;
  for (const Corner& corner : corners) {
    farthest = std::max(farthest, corner.nearest.triangle == triangle
                                      ? corner.nearest.distance
                                      : other.distanceTo(triangle, corner.point));
  }
  return farthest;
}

/// What to search for: points farther than `above`, until one is found that is farther than
/// `enough`; and how many triangles may be halved.
struct Search {
  double above = 0;
  double enough = std::numeric_limits<double>::infinity();
  std::uint64_t most = ~std::uint64_t{0};
};

/// The largest distance of a point of `mesh` from `other`, at most `tolerance` too small, or
/// `search.above` if that is greater. Nothing if that takes more work than is allowed.
std::optional<double> oneSided(const TriangleMesh& mesh, const TriangleTree& other,
                               double tolerance, const Search& search = {}) {
  std::vector<TriangleTree::Nearest> nearest(mesh.vertices.size());
  std::vector<bool> known(mesh.vertices.size());
  double farthest = search.above;
  for (const model::Triangle& triangle : mesh.triangles) {
    for (const std::uint32_t vertex : triangle) {
      if (known[vertex]) continue;
      known[vertex] = true;
      nearest[vertex] = other.nearest(mesh.vertices[vertex]);
      farthest = std::max(farthest, nearest[vertex].distance);
    }
  }

  std::priority_queue<Piece> pieces;
  const auto consider = [&](const std::array<Corner, 3>& corners) {
    double bound = std::numeric_limits<double>::infinity();
    for (const Corner& corner : corners) {
      bound = std::min(bound, farthestFrom(corner.nearest.triangle, corners, other));
      if (bound <= farthest + tolerance) return;
    }
    // Corners are often nearest to three triangles around the one that is nearest to the middle.
    const Point3 middle = (corners[0].point + corners[1].point + corners[2].point) / 3;
    const TriangleTree::Nearest near = other.nearest(middle);
    bound = std::min(bound, farthestFrom(near.triangle, corners, other));
    if (bound <= farthest + tolerance) return;
    farthest = std::max(farthest, near.distance);
    pieces.push({corners, bound});
  };
  for (const auto& [a, b, c] : mesh.triangles) {
    consider({{{mesh.vertices[a], nearest[a]},
               {mesh.vertices[b], nearest[b]},
               {mesh.vertices[c], nearest[c]}}});
  }
  for (std::uint64_t halved = 0;
       !pieces.empty() && pieces.top().atMost > farthest + tolerance && farthest <= search.enough;
       ++halved) {
    if (halved == search.most) return std::nullopt;
    const std::array<Corner, 3> corners = pieces.top().corners;
    pieces.pop();
    int longest = 0;
    double length = -1;
    for (int i = 0; i < 3; ++i) {
      const double edge = (corners[(i + 1) % 3].point - corners[i].point).squaredNorm();
      if (edge > length) {
        length = edge;
        longest = i;
      }
    }
    const Corner& from = corners[longest];
    const Corner& to = corners[(longest + 1) % 3];
    const Corner& opposite = corners[(longest + 2) % 3];
    Corner middle;
    middle.point = 0.5 * (from.point + to.point);
    middle.nearest = other.nearest(middle.point);
    farthest = std::max(farthest, middle.nearest.distance);
    consider({from, middle, opposite});
    consider({middle, to, opposite});
  }
  return farthest;
}

Error tooLong(double distance) {
  return fail(ErrorCode::Unsupported,
              fmt::format("whether the surfaces are within {} of each other takes too long to find "
                          "out; allow a larger distance",
                          distance));
}

/// Below this, distances are rounding errors, and halving would not end.
double toleranceOf(const TriangleMesh& a, const TriangleMesh& b, double relative) {
  constexpr double kLeast = 1e-12;
  model::Bounds3 bounds = model::boundsOf(a);
  bounds.add(model::boundsOf(b));
  return std::max(relative, kLeast) * (bounds.max - bounds.min).norm();
}

}  // namespace

SurfaceDistance surfaceDistance(const TriangleMesh& a, const TriangleMesh& b,
                                double relativeTolerance) {
  if (a.triangles.empty() && b.triangles.empty()) return {};
  if (a.triangles.empty() || b.triangles.empty()) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    return {a.triangles.empty() ? 0 : kInfinity, b.triangles.empty() ? 0 : kInfinity, 0};
  }
  const model::UnitScale scale = model::UnitScale::of({&a, &b});
  if (scale.changes()) {
    const auto [fromA, fromB, tolerance] =
        surfaceDistance(scale.toUnit(a), scale.toUnit(b), relativeTolerance);
    return {scale.fromUnit(fromA), scale.fromUnit(fromB), scale.fromUnit(tolerance)};
  }
  const double tolerance = toleranceOf(a, b, relativeTolerance);
  return {*oneSided(a, TriangleTree(b), tolerance), *oneSided(b, TriangleTree(a), tolerance),
          tolerance};
}

double farthestFrom(const TriangleMesh& a, const TriangleMesh& b, double relativeTolerance) {
  const model::UnitScale scale = model::UnitScale::of({&a, &b});
  if (scale.changes()) {
    return scale.fromUnit(farthestFrom(scale.toUnit(a), scale.toUnit(b), relativeTolerance));
  }
  const double tolerance = toleranceOf(a, b, relativeTolerance);
  return *oneSided(a, TriangleTree(b), tolerance) + tolerance;
}

Result<std::optional<double>> fartherThan(double distance, const TriangleMesh& a,
                                          const TriangleMesh& b) {
  if (a.triangles.empty() && b.triangles.empty()) return std::nullopt;
  if (a.triangles.empty() || b.triangles.empty()) return std::numeric_limits<double>::infinity();
  const model::UnitScale scale = model::UnitScale::of({&a, &b});
  if (scale.changes()) {
    auto found = fartherThan(scale.toUnit(distance), scale.toUnit(a), scale.toUnit(b));
    if (!found && found.error().code == ErrorCode::Unsupported) return tooLong(distance);
    if (found && *found) **found = scale.fromUnit(**found);
    return found;
  }
  constexpr double kFraction = 1e-3;
  const Search search{distance, distance, 4'000'000};
  for (const auto& [mesh, other] : {std::pair{&a, &b}, std::pair{&b, &a}}) {
    const auto found = oneSided(*mesh, TriangleTree(*other), kFraction * distance, search);
    if (!found) return tooLong(distance);
    if (*found > distance) return found;
  }
  return std::nullopt;
}

}  // namespace t4d::measure
