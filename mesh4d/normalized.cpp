#include "mesh4d/normalized.h"

#include <cmath>

namespace t4d::mesh4d {
namespace {

/// Two factors, since one may be beyond the range of doubles.
model::Point3 scaled(const model::Point3& point, int exponent) {
  const int half = exponent / 2;
  return point * std::ldexp(1.0, half) * std::ldexp(1.0, exponent - half);
}

}  // namespace

NormalizedMesh::NormalizedMesh(const model::TriangleMesh& mesh) {
  const model::Bounds3 bounds = boundsOf(mesh);
  if (bounds.empty()) return;
  const model::Point3 half = 0.5 * bounds.max - 0.5 * bounds.min;
  const model::Point3 middle = 0.5 * bounds.min + 0.5 * bounds.max;
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(middle[axis]) > 2 * half[axis]) origin_[axis] = middle[axis];
  }
  double largest = 0;
  for (const model::Point3& vertex : mesh.vertices) {
    largest = std::max(largest, (vertex - origin_).cwiseAbs().maxCoeff());
  }
  if (largest > 0) std::frexp(largest, &exponent_);
  mesh_.triangles = mesh.triangles;
  mesh_.vertices.reserve(mesh.vertices.size());
  for (const model::Point3& vertex : mesh.vertices) {
    mesh_.vertices.push_back(scaled(vertex - origin_, -exponent_));
  }
}

model::Point3 NormalizedMesh::toInput(const model::Point3& point) const {
  return scaled(point, exponent_) + origin_;
}

}  // namespace t4d::mesh4d
