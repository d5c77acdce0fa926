#pragma once

#include <optional>

#include "measure/triangle_tree.h"
#include "measure/winding_number.h"
#include "t4d/surface.h"

namespace t4d::edit {

/// A solid at one time, with queries about points.
class SolidSample {
 public:
  /// `mesh` is closed and has at least one triangle.
  explicit SolidSample(model::TriangleMesh mesh);

  const model::TriangleMesh& mesh() const { return mesh_; }
  const model::Bounds3& bounds() const { return bounds_; }

  struct Place {
    double distance = 0;  ///< from the surface; negative inside
    std::uint32_t triangle = 0;
    model::Point3 nearest = model::Point3::Zero();  ///< point of the surface
    model::Point3 out = model::Point3::Zero();      ///< unit vector away from the solid
  };
  Place at(const model::Point3& point) const;

  /// How far a point has to move along a unit vector to be `keep` away from the solid; nothing if
  /// that is more than `most`.
  std::optional<double> wayOut(const model::Point3& point, const model::Point3& along, double keep,
                               double most) const;

 private:
  model::TriangleMesh mesh_;
  model::Bounds3 bounds_;
  measure::TriangleTree tree_;
  measure::WindingNumber winding_;
};

/// Whether a point is within `distance` of bounds, along each axis.
bool isNear(const model::Bounds3& bounds, const model::Point3& point, double distance);

}  // namespace t4d::edit
