#pragma once

#include <array>
#include <span>

#include "measure/space_time_tetrahedron.h"

namespace t4d::measure {

/// Space-time seen along a direction in space: (u, v, t).
class View {
 public:
  explicit View(const model::Point3& direction) : direction_(direction) {
    axes_.row(0) = direction.unitOrthogonal().transpose();
    axes_.row(1) = direction.cross(axes_.row(0).transpose()).transpose();
  }

  const model::Point3& direction() const { return direction_; }
  model::Point3 inSpace(const Eigen::Vector2d& across) const { return axes_.transpose() * across; }
  model::Point3 operator()(const model::Point4& point) const {
    const Eigen::Vector2d across = axes_ * point.head<3>();
    return {across[0], across[1], point[3]};
  }

 private:
  model::Point3 direction_;
  Eigen::Matrix<double, 2, 3> axes_;
};

/// The range of points along a direction.
struct Range {
  double least = 0;
  double most = 0;

  Range() = default;
  Range(const model::Point3& direction, std::span<const model::Point3> points);

  /// Whether this one, if it has a length, and another have at most an end in common, up to
  /// rounding.
  bool isApartFrom(const Range& other) const;
};

/// A part of a cell, a tetrahedron, as it is seen in a view.
class SeenPart {
 public:
  SeenPart(const View& view, const std::array<model::Point4, 4>& corners);

  const std::array<model::Point3, 4>& corners() const { return seen_; }

  /// Whether a triangle has no point inside it: a plane lies between them (the separating axes of
  /// two convex polytopes).
  bool isApartFrom(const std::array<model::Point3, 3>& triangle) const;

  /// Whether another tetrahedron, which faces the viewer, is within a distance along the view
  /// wherever both are seen one behind the other.
  bool isNear(const SpaceTimeTetrahedron& other, double distance) const;

 private:
  View view_;
  std::array<model::Point4, 4> corners_;
  std::array<model::Point3, 4> seen_;
  std::array<model::Point3, 7> directions_;  // along which a triangle is most often apart
  std::array<Range, 7> ranges_;              // of the corners along them
};

}  // namespace t4d::measure
