#pragma once

#include <span>
#include <vector>

#include "t4d/mesh.h"

namespace t4d::edit {

/// A time when a body touches an obstacle, or is too near.
struct ContactTime {
  model::TimeSpan span;
  double time = 0;  ///< when it is deepest or nearest, within the contact
  model::Point3 place = model::Point3::Zero();  ///< about where
  std::string obstacle;
};

/// All times when a body touches any of the obstacles or is nearer than `clearance`, in order.
/// Empty if it is clear, by an exact test.
Result<std::vector<ContactTime>> contactTimes(std::span<const model::Body> obstacles,
                                              const model::Body& body, double clearance,
                                              const model::Progress& progress = {});

}  // namespace t4d::edit
