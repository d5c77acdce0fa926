#pragma once

#include "t4d/mesh.h"

namespace t4d::model {

/// The apex of a cone that closes a surface with these bounds. It is off the centre by `offCentre`
/// times irregular fractions of the extent, so that it is not in the plane of any triangle of a
/// symmetric surface. A cell in such a plane would have no volume.
inline Point3 coneApex(const Bounds3& bounds, double offCentre) {
  const Point3 fractions(0.0137, 0.0291, 0.0173);
  // Halve first: the extent of the bounds may overflow a double.
  const Point3 half = 0.5 * bounds.max - 0.5 * bounds.min;
  return 0.5 * bounds.min + 0.5 * bounds.max + (2 * offCentre * fractions).cwiseProduct(half);
}

}  // namespace t4d::model
