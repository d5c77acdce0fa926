#pragma once

#include "t4d/surface.h"

namespace t4d::mesh4d {

/// A copy of a mesh at the origin and of size about 1, for code that computes with products of
/// coordinates. The copy is exact: it is scaled by a power of two, and moved along an axis only if
/// the mesh is farther from the origin than it is wide, since the differences are then exact.
class NormalizedMesh {
 public:
  explicit NormalizedMesh(const model::TriangleMesh& mesh);

  const model::TriangleMesh& mesh() const { return mesh_; }
  /// The point of the input mesh for a point of the copy.
  model::Point3 toInput(const model::Point3& point) const;

 private:
  model::TriangleMesh mesh_;
  model::Point3 origin_ = model::Point3::Zero();
  int exponent_ = 0;  // a point of the input is its copy times two to this power, plus the origin
};

}  // namespace t4d::mesh4d
