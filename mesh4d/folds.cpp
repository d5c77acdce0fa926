#include "mesh4d/folds.h"

#include <algorithm>
#include <cstdint>
#include <limits>

namespace t4d::mesh4d {
namespace {

using Eigen::Vector3d;
using model::Point4;

enum class Facing : std::uint8_t { Forward, Unknown, Backward };

/// The prism of a triangle in a step, seen by an observer who moves with its middle: that changes
/// no determinant, and rounding is that of the triangle, however far it goes.
class StepPrism {
 public:
  StepPrism(const model::Triangle& triangle, const model::Slab& step) : step_(step) {
    const auto lower = step.lowerLayer();
    const auto upper = step.upperLayer();
    double largest = 0;
    for (const std::uint32_t corner : triangle) {
      const Vector3d before = lower[corner].head<3>();
      const Vector3d after = upper[corner].head<3>();
      middle_ += before / 3;
      way_ += (after - before) / 3;
      largest = std::max({largest, before.cwiseAbs().maxCoeff(), after.cwiseAbs().maxCoeff()});
    }
    // The rounding of a position and of a mean of four positions.
    constexpr double kRounding = 4 * std::numeric_limits<double>::epsilon();
    rounding_ = kRounding * largest;
    const auto edge = [&](std::span<const Point4> layer, int corner) -> Vector3d {
      return (layer[triangle[corner]] - layer[triangle[0]]).head<3>();
    };
    const Vector3d u0 = edge(lower, 1);
    const Vector3d v0 = edge(lower, 2);
    const Vector3d u1 = edge(upper, 1);
    const Vector3d v1 = edge(upper, 2);
    // The integral of the area vector of a triangle whose corners go straight, up to a positive
    // factor: with edges u and v it is a quadratic Bezier curve with the control points u0 x v0,
    // (u0 x v1 + u1 x v0) / 2 and u1 x v1, whose mean is that of these three.
    direction_ = u0.cross(v0) + (u0.cross(v1) + u1.cross(v0)) / 2 + u1.cross(v1);
    directionError_ = 3 * rounding_ * (u0.norm() + v0.norm() + u1.norm() + v1.norm());
    isSliver_ = isNarrow(u0, v0) && isNarrow(u1, v1);
  }

  /// Whether the triangle has no direction in either layer.
  bool isSliver() const { return isSliver_; }

  /// The sign of det[(n, 0), b-a, c-a, d-a], with n the mean direction.
  Facing facingOf(const model::Cell& cell) const {
    const Point4 a = seen(cell[0]);
    const Point4 b = seen(cell[1]) - a;
    const Point4 c = seen(cell[2]) - a;
    const Point4 d = seen(cell[3]) - a;
    const double reach = std::max({b.head<3>().norm(), c.head<3>().norm(), d.head<3>().norm()});
    double sum = 0;
    double error = 0;
    const auto add = [&](double time, const Point4& p, const Point4& q) {
      const Vector3d area = p.head<3>().cross(q.head<3>());
      sum += time * direction_.dot(area);
      error += std::abs(time) *
               (direction_.norm() * rounding_ * 4 * reach + directionError_ * area.norm());
    };
    add(b[3], c, d);
    add(-c[3], b, d);
    add(d[3], b, c);
    if (sum > error) return Facing::Forward;
    return sum < -error ? Facing::Backward : Facing::Unknown;
  }

 private:
  /// Far more than what leaves a sign unknown: cells are parts of the triangle.
  bool isNarrow(const Vector3d& u, const Vector3d& v) const {
    constexpr double kWidths = 128;
    return u.cross(v).norm() <= kWidths * rounding_ * std::max(u.norm(), v.norm());
  }

  Point4 seen(std::uint32_t vertex) const {
    Point4 point = step_.vertices[vertex];
    const double part = (point[3] - step_.timeBegin) / (step_.timeEnd - step_.timeBegin);
    point.head<3>() -= middle_ + part * way_;
    return point;
  }

  const model::Slab& step_;
  Vector3d middle_ = Vector3d::Zero();  // of the triangle in the lower layer
  Vector3d way_ = Vector3d::Zero();     // from there to the upper one
  double rounding_ = 0;                 // of a position
  Vector3d direction_;
  double directionError_ = 0;
  bool isSliver_ = false;
};

}  // namespace

std::optional<Fold> foldOf(const model::TriangleMesh& mesh, const model::Slab& step) {
  const auto& cells = step.connectivity->cells;
  const std::size_t perPrism = cells.size() / mesh.triangles.size();
  const auto lower = step.lowerLayer();
  const auto upper = step.upperLayer();
  std::optional<Fold> fold;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const model::Triangle& triangle = mesh.triangles[i];
    const StepPrism prism(triangle, step);
    bool folded = false;
    for (std::size_t k = i * perPrism; k < (i + 1) * perPrism && !folded; ++k) {
      const Facing facing = prism.facingOf(cells[k]);
      folded = facing == Facing::Backward || (facing == Facing::Unknown && !prism.isSliver());
    }
    if (!folded) continue;
    if (!fold) {
      Vector3d sum = Vector3d::Zero();
      for (const std::uint32_t corner : triangle) sum += (lower[corner] + upper[corner]).head<3>();
      fold = Fold{{step.timeBegin, step.timeEnd}, 0, static_cast<std::uint32_t>(i), sum / 6};
    }
    ++fold->prisms;
  }
  return fold;
}

bool foldsNowhere(const model::Affine3x4& from, const model::Affine3x4& to) {
  const Eigen::Matrix3d p = from.leftCols<3>();
  const Eigen::Matrix3d q = to.leftCols<3>();
  // The mean over the columns of p, each replaced by that of q.
  const auto mixed = [](const Eigen::Matrix3d& most, const Eigen::Matrix3d& one) {
    return (one.col(0).dot(most.col(1).cross(most.col(2))) +
            one.col(1).dot(most.col(2).cross(most.col(0))) +
            one.col(2).dot(most.col(0).cross(most.col(1)))) /
           3;
  };
  const double first = p.determinant();
  return first * mixed(p, q) > 0 && first * mixed(q, p) > 0 && first * q.determinant() > 0;
}

}  // namespace t4d::mesh4d
