#pragma once

#include "edit/collapse_patch.h"
#include "edit/patch.h"

namespace t4d::edit {

/// Vertices and cells of the mesh that a patch was made from, with times as in the patch.
struct Original {
  std::vector<model::Point4> vertices;
  std::vector<model::Cell> cells;
};

Original originalOf(const Patch& patch);
/// The union of two originals.
Original joined(Original one, const Original& other);

/// Calls `collapsed` such that the Hausdorff distance between slices of the result and of the
/// original at the same time is at most `maxError`. Where this cannot be proved
/// (measure::SliceBound), the last collapses are left out. The given patch must itself be near
/// enough, and have samples.
Patch provedCollapse(const Patch& given, const Original& original, double maxError,
                     const CollapseOptions& options);

}  // namespace t4d::edit
