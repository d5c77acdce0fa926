#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "t4d/check.h"

namespace t4d::measure {
namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;

/// A tetrahedron in space, congruent to one in R^4 whose first corner is the origin: the edges from
/// there in coordinates of the orthonormal frame that they make one after another. Orthogonalized
/// twice, so that a thin cell keeps the digits of its height.
std::array<Vector3d, 3> inItsOwnSpace(const std::array<Vector4d, 3>& edges) {
  std::array<Vector4d, 3> axes;
  std::array<Vector3d, 3> local;
  for (int i = 0; i < 3; ++i) {
    Vector4d rest = edges[i];
    local[i].setZero();
    for (int pass = 0; pass < 2; ++pass) {
      for (int k = 0; k < i; ++k) {
        const double along = rest.dot(axes[k]);
        local[i][k] += along;
        rest -= along * axes[k];
      }
    }
    // Edges are in units of the longest component: lengths within rounding count as 0.
    constexpr double kRounding = 16 * std::numeric_limits<double>::epsilon();
    local[i][i] = rest.norm();
    if (local[i][i] <= kRounding) local[i][i] = 0;
    axes[i] = local[i][i] > 0 ? Vector4d(rest / local[i][i]) : Vector4d(Vector4d::Zero());
  }
  return local;
}

/// The angle between two vectors in degrees; exact for small ones, too.
double degreesBetween(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / std::numbers::pi;
}

}  // namespace

CellQuality qualityOf(const std::array<model::Point4, 4>& corners, double timeScale) {
  std::array<Vector4d, 3> edges;
  double longest = 0;
  for (int i = 0; i < 3; ++i) {
    edges[i] = corners[i + 1] - corners[0];
    edges[i][3] *= timeScale;
    longest = std::max(longest, edges[i].cwiseAbs().maxCoeff());
  }
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  CellQuality quality{0, kInfinity, kInfinity, 0, 180, 0};
  if (!(longest > 0)) return quality;
  // In units of the longest component, products of six lengths neither overflow nor vanish.
  for (Vector4d& edge : edges) edge /= longest;
  const std::array<Vector3d, 3> at = inItsOwnSpace(edges);
  const std::array<Vector3d, 4> p = {Vector3d::Zero(), at[0], at[1], at[2]};
  const double volume = at[0][0] * at[1][1] * at[2][2] / 6;
  quality.volume = volume * longest * longest * longest;

  std::array<double, 6> lengths;
  constexpr std::array<std::array<int, 2>, 6> kEdges = {
      {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};
  for (std::size_t e = 0; e < 6; ++e) lengths[e] = (p[kEdges[e][1]] - p[kEdges[e][0]]).norm();
  const auto [shortestEdge, longestEdge] = std::ranges::minmax(lengths);
  quality.edgeRatio = longestEdge / shortestEdge;
  if (!(volume > 0)) return quality;

  // Each normal has the length of twice the area, all outward or all inward; side i lies opposite
  // corner i.
  const std::array<Vector3d, 4> normals = {(p[2] - p[1]).cross(p[3] - p[1]), p[3].cross(p[2]),
                                           p[1].cross(p[3]), p[2].cross(p[1])};
  std::array<double, 4> sides;
  for (int i = 0; i < 4; ++i) sides[i] = normals[i].norm();
  const double areas = sides[0] + sides[1] + sides[2] + sides[3];
  // The circumcentre is as far from each corner as from the first: 2 center . p = p . p, solved
  // from the first axis to the last. (Formulas from the lengths of the edges lose the digits of
  // needles.)
  Vector3d center;
  center[0] = p[1][0] / 2;
  center[1] = (p[2][0] * (p[2][0] - p[1][0]) + p[2][1] * p[2][1]) / (2 * p[2][1]);
  center[2] =
      (p[3][0] * (p[3][0] - p[1][0]) + p[3][1] * (p[3][1] - 2 * center[1]) + p[3][2] * p[3][2]) /
      (2 * p[3][2]);
  const double inradius = 6 * volume / areas;
  quality.radiusRatio = std::max(1.0, center.norm() / (3 * inradius));
  quality.height = 6 * volume / (std::ranges::max(sides) * longestEdge);

  // The extreme angles have the extreme cosines.
  double largestCosine = -2;
  double smallestCosine = 2;
  const auto degreesAt = [&](int i, int j) { return degreesBetween(normals[i], -normals[j]); };
  std::array<int, 2> smallest{};
  std::array<int, 2> largest{};
  for (int i = 0; i < 4; ++i) {
    for (int j = i + 1; j < 4; ++j) {
      const double cosine = -normals[i].dot(normals[j]) / (sides[i] * sides[j]);
      if (cosine > largestCosine) {
        largestCosine = cosine;
        smallest = {i, j};
      }
      if (cosine < smallestCosine) {
        smallestCosine = cosine;
        largest = {i, j};
      }
    }
  }
  quality.smallestAngle = degreesAt(smallest[0], smallest[1]);
  quality.largestAngle = degreesAt(largest[0], largest[1]);
  return quality;
}

}  // namespace t4d::measure
