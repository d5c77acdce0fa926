#pragma once

#include <vector>

#include "measure/components.h"
#include "model/orderless_sum.h"
#include "t4d/check.h"

namespace t4d::measure {

/// Findings in some consecutive slabs of a mesh, which add up to those in all of them.
struct PartOfMesh {
  MeshReport found;  ///< without what follows, and `components`
  model::OrderlessSum hypervolume;
  model::OrderlessSum hypervolumeMagnitude;  ///< of the slabs, each taken as positive
  model::OrderlessSum boundaryVolume;
  bool hasPositive = false;  ///< a slab of positive hypervolume
  bool hasNegative = false;
  ComponentSpan components;
};

/// The report on a mesh of which these are the parts, in order, the first of which begins it and
/// the last of which ends it: bit for bit that of checkMesh. Fails if the parts do not follow one
/// another.
Result<MeshReport> joinedReport(const std::vector<PartOfMesh>& parts);

}  // namespace t4d::measure
