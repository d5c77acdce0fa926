#pragma once

#include <span>
#include <vector>

#include "measure/collision_verdict.h"

namespace t4d::measure {

/// The clearance of two solids at a time.
struct ClearanceSample {
  double time = 0;
  double distance = 0;    ///< of the meshes; 0 in contact
  double lowerBound = 0;  ///< the true solids are apart by at least this
  /// A lower bound of how deep the meshes overlap (OverlapDepth); 0 without contact.
  double overlapDepth = 0;
};

/// Samples at those of `times` at which both solids exist. `collision` and `verdict` are those of
/// the two (collide, verdictOn); what is known of their motions makes the lower bound. Distances
/// are those of light slices, where there are any (slice::LightSlicer), and the bound says how far
/// these are off. Fails if a source does.
Result<std::vector<ClearanceSample>> clearanceOverTime(const model::Source& a,
                                                       const model::Source& b,
                                                       const Collision& collision,
                                                       const CollisionVerdict& verdict,
                                                       std::span<const double> times,
                                                       const model::Progress& progress = {});

}  // namespace t4d::measure
