#pragma once

#include <cstdint>
#include <optional>

#include "model/geometry.h"

namespace t4d::formats {

/// A lattice of positions (SPEC.md, section "Positions"): each coordinate is
/// origin + step x number, in double precision.
struct Grid {
  model::Point3 origin = model::Point3::Zero();
  double step = 1;  ///< positive and finite

  double coordinate(int axis, std::int32_t number) const;
  /// Of the nearest coordinate; empty if it is out of range.
  std::optional<std::int32_t> number(int axis, double coordinate) const;
  /// The nearest point, whose numbers must be in range.
  model::Point3 nearest(const model::Point3& point) const;

  /// The grid of this step for a mesh about `point`: its origin is 0 on each axis on which numbers
  /// suffice for twice as far, and otherwise the multiple of the step that is nearest to the point.
  static Grid about(const model::Point3& point, double step);

  friend bool operator==(const Grid& a, const Grid& b) {
    return a.origin == b.origin && a.step == b.step;
  }
};

}  // namespace t4d::formats
