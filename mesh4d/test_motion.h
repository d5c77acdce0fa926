#pragma once

#include <span>

#include "t4d/motion.h"

namespace t4d::mesh4d {

/// One segment starting at time 0 that rotates about an axis through the origin.
inline model::Motion turnAbout(const Eigen::Vector3d& axis, double degrees, double duration = 1) {
  model::ScrewRun run;
  run.duration = duration;
  run.screw.axisDirection = axis;
  run.screw.angleDegrees = degrees;
  return *model::chainScrews(0, std::span(&run, 1));
}

}  // namespace t4d::mesh4d
