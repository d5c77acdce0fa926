#include "t4d/mesh4d/folds.h"

namespace t4d::mesh4d {
namespace {

using Eigen::Vector3d;
using model::Point4;

/// The integral of the area vector of a triangle whose corners go straight from `lower` to `upper`,
/// up to a positive factor. With edges u and v it is a quadratic Bezier curve with the control
/// points u0 x v0, (u0 x v1 + u1 x v0) / 2 and u1 x v1, whose mean is that of these three.
Vector3d meanDirection(const model::Triangle& triangle, std::span<const Point4> lower,
                       std::span<const Point4> upper) {
  const auto edge = [&](std::span<const Point4> layer, int corner) -> Vector3d {
    return (layer[triangle[corner]] - layer[triangle[0]]).head<3>();
  };
  const Vector3d u0 = edge(lower, 1);
  const Vector3d v0 = edge(lower, 2);
  const Vector3d u1 = edge(upper, 1);
  const Vector3d v1 = edge(upper, 2);
  return u0.cross(v0) + (u0.cross(v1) + u1.cross(v0)) / 2 + u1.cross(v1);
}

/// det[(n, 0), b-a, c-a, d-a], expanded along the times.
double facing(const Vector3d& n, const model::Cell& cell, std::span<const Point4> vertices) {
  const Point4& a = vertices[cell[0]];
  const Point4 b = vertices[cell[1]] - a;
  const Point4 c = vertices[cell[2]] - a;
  const Point4 d = vertices[cell[3]] - a;
  const Vector3d bn = n.cross(b.head<3>());
  const Vector3d cn = n.cross(c.head<3>());
  return b[3] * cn.dot(d.head<3>()) - c[3] * bn.dot(d.head<3>()) + d[3] * bn.dot(c.head<3>());
}

}  // namespace

std::optional<Fold> foldOf(const model::TriangleMesh& mesh, const model::Slab& step) {
  const auto& cells = step.connectivity->cells;
  const std::size_t perPrism = cells.size() / mesh.triangles.size();
  const auto lower = step.lowerLayer();
  const auto upper = step.upperLayer();
  std::optional<Fold> fold;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const model::Triangle& triangle = mesh.triangles[i];
    const Vector3d n = meanDirection(triangle, lower, upper);
    bool folded = false;
    for (std::size_t k = i * perPrism; k < (i + 1) * perPrism; ++k) {
      folded |= !(facing(n, cells[k], step.vertices) > 0);
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

}  // namespace t4d::mesh4d
