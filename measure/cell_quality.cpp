#include "measure/cell_quality.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace t4d::measure {
namespace {

/// A number of each of the cells. What one cell takes is mostly waiting for square roots and
/// divisions, which depend on one another: four cells at once take less than half of the time.
using Lanes = Eigen::Array<double, kCellsTogether, 1>;

struct Vector4 {
  std::array<Lanes, 4> at;

  Lanes dot(const Vector4& other) const {
    return (at[0] * other.at[0] + at[2] * other.at[2]) +
           (at[1] * other.at[1] + at[3] * other.at[3]);
  }
};

struct Vector3 {
  Lanes x;
  Lanes y;
  Lanes z;

  Lanes dot(const Vector3& other) const { return x * other.x + y * other.y + z * other.z; }
  Lanes norm() const { return dot(*this).sqrt(); }
  Vector3 cross(const Vector3& other) const {
    return {y * other.z - z * other.y, z * other.x - x * other.z, x * other.y - y * other.x};
  }
};

/// Tetrahedra in space, congruent to those in R^4 whose first corners are the origin.
struct InTheirOwnSpace {
  /// The edges from the first corner, in coordinates of the orthonormal frame that they make one
  /// after another: the first has one, the second two. Orthogonalized twice, so that a thin cell
  /// keeps the digits of its height.
  explicit InTheirOwnSpace(const std::array<Vector4, 3>& edges) {
    std::array<Vector4, 3> axes;
    for (int i = 0; i < 3; ++i) {
      Vector4 rest = edges[i];
      for (int k = 0; k < i; ++k) local[i][k].setZero();
      for (int pass = 0; pass < 2; ++pass) {
        for (int k = 0; k < i; ++k) {
          const Lanes along = rest.dot(axes[k]);
          local[i][k] += along;
          for (int n = 0; n < 4; ++n) rest.at[n] -= along * axes[k].at[n];
        }
      }
      // Edges are in units of the longest component: lengths within rounding count as 0.
      constexpr double kRounding = 16 * std::numeric_limits<double>::epsilon();
      const Lanes length = rest.dot(rest).sqrt();
      // 1 where a length is larger, 0 elsewhere; comparisons of lanes are not vectorised.
      constexpr double kHuge = 1e300;
      const Lanes counts = ((length - kRounding).max(0.0) * kHuge).min(1.0);
      local[i][i] = length * counts;
      const Lanes divisor = local[i][i] + (1 - counts);
      for (int n = 0; n < 4; ++n) axes[i].at[n] = rest.at[n] / divisor * counts;
    }
  }

  std::array<std::array<Lanes, 3>, 3> local;
};

/// The pair of sides with the largest of some numbers, of each cell.
class Sides {
 public:
  void take(int i, int j, const Lanes& numbers) {
    for (Eigen::Index cell = 0; cell < numbers.size(); ++cell) {
      const bool larger = numbers[cell] > largest_[cell];
      largest_[cell] = larger ? numbers[cell] : largest_[cell];
      first_[cell] = larger ? i : first_[cell];
      second_[cell] = larger ? j : second_[cell];
    }
  }

  /// The angles between them in degrees; exact for small ones, too.
  Lanes degrees(const std::array<Vector3, 4>& normals) const {
    Vector3 a;
    Vector3 b;
    for (Eigen::Index cell = 0; cell < a.x.size(); ++cell) {
      const Vector3& first = normals[first_[cell]];
      const Vector3& second = normals[second_[cell]];
      a.x[cell] = first.x[cell];
      a.y[cell] = first.y[cell];
      a.z[cell] = first.z[cell];
      b.x[cell] = -second.x[cell];
      b.y[cell] = -second.y[cell];
      b.z[cell] = -second.z[cell];
    }
    const Lanes sine = a.cross(b).norm();
    const Lanes cosine = a.dot(b);
    const auto angle = [](double y, double x) { return std::atan2(y, x); };
    return sine.binaryExpr(cosine, angle) * 180 / std::numbers::pi;
  }

 private:
  Lanes largest_ = Lanes::Constant(-2);
  std::array<int, kCellsTogether> first_{};
  std::array<int, kCellsTogether> second_{};
};

}  // namespace

std::array<CellQuality, kCellsTogether> qualitiesOf(const CellsTogether& cells, double timeScale) {
  std::array<Vector4, 3> edges;
  Lanes unit = Lanes::Zero();  // the longest component
  for (int i = 0; i < 3; ++i) {
    for (int axis = 0; axis < 4; ++axis) {
      Lanes& edge = edges[i].at[axis];
      for (std::size_t cell = 0; cell < kCellsTogether; ++cell) {
        edge[static_cast<Eigen::Index>(cell)] = cells[cell][i + 1][axis] - cells[cell][0][axis];
      }
      if (axis == 3) edge *= timeScale;
      unit = unit.max(edge.abs());
    }
  }
  // In units of the longest component, products of six lengths neither overflow nor vanish.
  for (Vector4& edge : edges) {
    for (Lanes& component : edge.at) component /= unit;
  }
  // Cells whose corners are equal or lie in a plane give numbers here that are dropped below.
  const auto at = InTheirOwnSpace(edges).local;
  const Lanes& p1x = at[0][0];
  const auto& [p2x, p2y, noP2z] = at[1];
  const auto& [p3x, p3y, p3z] = at[2];
  const Lanes zero = Lanes::Zero();
  const Lanes volume = p1x * p2y * p3z / 6;

  // From corner to corner; what is 0 is left out.
  const Vector3 p13 = {p3x - p1x, p3y, p3z};
  const Vector3 p23 = {p3x - p2x, p3y - p2y, p3z};
  const Lanes p12x = p2x - p1x;
  const std::array<Lanes, 6> lengths = {(p1x * p1x).sqrt(),
                                        (p2x * p2x + p2y * p2y).sqrt(),
                                        Vector3{p3x, p3y, p3z}.norm(),
                                        (p12x * p12x + p2y * p2y).sqrt(),
                                        p13.norm(),
                                        p23.norm()};
  Lanes shortestEdge = lengths[0];
  Lanes longestEdge = lengths[0];
  for (const Lanes& length : lengths) {
    shortestEdge = shortestEdge.min(length);
    longestEdge = longestEdge.max(length);
  }

  // Each normal has the length of twice the area, all outward or all inward; side i lies opposite
  // corner i.
  const std::array<Vector3, 4> normals = {{{p2y * p3z, -(p12x * p3z), p12x * p3y - p2y * p13.x},
                                           {-(p3z * p2y), p3z * p2x, p3x * p2y - p3y * p2x},
                                           {zero, -(p1x * p3z), p1x * p3y},
                                           {zero, zero, -(p2y * p1x)}}};
  std::array<Lanes, 4> sides;
  for (int i = 0; i < 4; ++i) sides[i] = normals[i].norm();
  const Lanes areas = sides[0] + sides[1] + sides[2] + sides[3];
  const Lanes largestSide = sides[0].max(sides[1]).max(sides[2].max(sides[3]));
  // The circumcentre is as far from each corner as from the first: 2 center . p = p . p, solved
  // from the first axis to the last. (Formulas from the lengths of the edges lose the digits of
  // needles.)
  Vector3 center;
  center.x = p1x / 2;
  center.y = (p2x * p12x + p2y * p2y) / (2 * p2y);
  center.z = (p3x * p13.x + p3y * (p3y - 2 * center.y) + p3z * p3z) / (2 * p3z);
  const Lanes inradius = 6 * volume / areas;
  const Lanes radiusRatio = center.norm() / (3 * inradius);
  const Lanes height = 6 * volume / (largestSide * longestEdge);
  const Lanes edgeRatio = longestEdge / shortestEdge;

  // The extreme angles have the extreme cosines.
  Sides smallest;
  Sides largest;
  for (int i = 0; i < 4; ++i) {
    for (int j = i + 1; j < 4; ++j) {
      const Lanes cosine = normals[i].dot(normals[j]) / (sides[i] * sides[j]);
      smallest.take(i, j, -cosine);
      largest.take(i, j, cosine);
    }
  }

  const Lanes smallestAngle = smallest.degrees(normals);
  const Lanes largestAngle = largest.degrees(normals);

  std::array<CellQuality, kCellsTogether> qualities;
  for (std::size_t cell = 0; cell < kCellsTogether; ++cell) {
    const auto k = static_cast<Eigen::Index>(cell);
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    CellQuality& quality = qualities[cell];
    quality = {0, kInfinity, kInfinity, 0, 180, 0};
    if (!(unit[k] > 0)) continue;
    quality.volume = volume[k] * unit[k] * unit[k] * unit[k];
    quality.edgeRatio = edgeRatio[k];
    if (!(volume[k] > 0)) continue;
    quality.radiusRatio = std::max(1.0, radiusRatio[k]);
    quality.height = height[k];
    quality.smallestAngle = smallestAngle[k];
    quality.largestAngle = largestAngle[k];
  }
  return qualities;
}

CellQuality qualityOf(const std::array<model::Point4, 4>& corners, double timeScale) {
  CellsTogether same;
  same.fill(corners);
  return qualitiesOf(same, timeScale).front();
}

}  // namespace t4d::measure
