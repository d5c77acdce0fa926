#pragma once

#include <span>
#include <vector>

#include "t4d/model/body.h"

namespace t4d::edit {

/// When a body is in contact, or too near.
struct ContactTime {
  model::TimeSpan span;
  double time = 0;                              ///< within, when it is deepest or nearest
  model::Point3 place = model::Point3::Zero();  ///< about where
  std::string obstacle;
};

/// All contacts of a body with any of the obstacles, nearer than `clearance` included, in the order
/// of time; none if it is clear, by an exact test.
Result<std::vector<ContactTime>> contactTimes(std::span<const model::Body> obstacles,
                                              const model::Body& body, double clearance,
                                              const model::Progress& progress = {});

}  // namespace t4d::edit
