#include "formats/triangle/rounding_loss.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "model/surface_components.h"
#include "model/union_find.h"
#include "t4d/mesh.h"

namespace t4d::formats {
namespace {

using model::Point3;
using model::Point4;

/// Sets the power of two by which an extent becomes about 1, so that products of extents neither
/// overflow nor vanish; once, for what is summed up to be comparable.
void setUnit(double& scale, double extent) {
  constexpr int kMost = std::numeric_limits<double>::max_exponent - 1;
  if (scale != 0 || !(extent > 0) || !std::isfinite(extent)) return;
  scale = std::exp2(std::min(-std::ilogb(extent), kMost));
}

/// Six times the volume of a cell, in the direction of its normal, after its edges are multiplied
/// by `scale`.
Eigen::Vector4d normalOf(const model::Cell& cell, const std::vector<Point4>& vertices,
                         const Eigen::Array4d& scale) {
  const Point4& a = vertices[cell[0]];
  Eigen::Matrix<double, 4, 3> edges;
  for (int k = 0; k < 3; ++k) edges.col(k) = (vertices[cell[k + 1]] - a).array() * scale;
  Eigen::Vector4d normal;
  for (int row = 0; row < 4; ++row) {
    Eigen::Matrix3d minor;
    for (int i = 0; i < 3; ++i) minor.row(i) = edges.row(i < row ? i : i + 1);
    normal[row] = (row % 2 == 0 ? 1 : -1) * minor.determinant();
  }
  return normal;
}

}  // namespace

void RoundingLoss::add(double measure, bool kept, Part& part) {
  ++elementCount_;
  part.measure += measure;
  if (kept || !(measure > 0)) return;
  ++lostCount_;
  part.lost += measure;
}

void RoundingLoss::addParts(const std::vector<Part>& parts) {
  constexpr double kNegligible = 1e-3;
  for (const Part& part : parts) {
    all_.measure += part.measure;
    all_.lost += part.lost;
    partLost_ = partLost_ || part.lost > kNegligible * part.measure;
  }
}

void RoundingLoss::add(const model::TriangleMesh& mesh,
                       const std::vector<Eigen::Vector3f>& rounded) {
  for (const Point3& vertex : mesh.vertices) {
    farthest_ = std::max(farthest_, vertex.cwiseAbs().maxCoeff());
  }
  model::UnionFind sets = componentsOf(mesh);
  model::Bounds3 bounds;
  for (const Point3& vertex : mesh.vertices) bounds.add(vertex);
  if (!mesh.vertices.empty()) setUnit(unit_[0], (bounds.max - bounds.min).maxCoeff());
  const double scale = unit_[0];
  std::vector<Part> parts(mesh.vertices.size());  // by the first vertex of each
  for (const auto& [a, b, c] : mesh.triangles) {
    const auto& v = mesh.vertices;
    const Eigen::Vector3d before = ((v[b] - v[a]) * scale).cross((v[c] - v[a]) * scale);
    const Eigen::Vector3d from = rounded[a].cast<double>();
    const Eigen::Vector3d first = (rounded[b].cast<double>() - from) * scale;
    const Eigen::Vector3d second = (rounded[c].cast<double>() - from) * scale;
    add(before.norm(), before.dot(first.cross(second)) > 0, parts[sets.root(a)]);
  }
  addParts(parts);
}

void RoundingLoss::add(const model::Slab& slab, const model::Slab& rounded) {
  elements_ = "cells";
  for (const Point4& vertex : slab.vertices) {
    farthest_ = std::max(farthest_, vertex.head<3>().cwiseAbs().maxCoeff());
  }
  model::UnionFind sets(slab.vertices.size());
  for (const model::Cell& cell : slab.connectivity->cells) {
    for (int k = 1; k < 4; ++k) sets.unite(cell[0], cell[k]);
  }
  model::Bounds4 bounds;
  for (const Point4& vertex : slab.vertices) bounds.add(vertex);
  if (!slab.vertices.empty()) {
    const Point4 size = bounds.max - bounds.min;
    setUnit(unit_[0], size.head<3>().maxCoeff());
    setUnit(unit_[1], size[3]);
  }
  const auto orOne = [](double unit) { return unit == 0 ? 1 : unit; };
  const double inSpace = orOne(unit_[0]);
  const Eigen::Array4d scale(inSpace, inSpace, inSpace, orOne(unit_[1]));
  std::vector<Part> parts(slab.vertices.size());
  for (const model::Cell& cell : slab.connectivity->cells) {
    const Eigen::Vector4d before = normalOf(cell, slab.vertices, scale);
    add(before.norm(), before.dot(normalOf(cell, rounded.vertices, scale)) > 0,
        parts[sets.root(cell[0])]);
  }
  addParts(parts);
}

std::optional<std::string> RoundingLoss::line() const {
  constexpr double kNegligible = 1e-6;
  if (!partLost_ && !(all_.lost > kNegligible * all_.measure)) return std::nullopt;
  if (step_) {
    return fmt::format(
        "shape: {} of {} {} become flat or turn over on a grid of step {}; use a smaller step, or "
        "no grid",
        lostCount_, elementCount_, elements_, *step_);
  }
  if (moved_) {
    return fmt::format(
        "shape: {} of {} {} become flat or turn over where doubles are too coarse; move the mesh, "
        "or shift its times, less far from 0",
        lostCount_, elementCount_, elements_);
  }
  const auto farthest = static_cast<float>(farthest_);
  const float spacing = std::nextafter(farthest, std::numeric_limits<float>::infinity()) - farthest;
  return fmt::format(
      "shape: {} of {} {} become flat or turn over in float32, which has steps of {:.3g} at "
      "coordinates of {:.3g}; move the mesh nearer to the origin, or write it in float64",
      lostCount_, elementCount_, elements_, spacing, farthest_);
}

}  // namespace t4d::formats
