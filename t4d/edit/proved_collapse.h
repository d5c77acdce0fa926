#pragma once

#include "t4d/edit/collapse_patch.h"
#include "t4d/edit/patch.h"

namespace t4d::edit {

/// Vertices and cells of the mesh that a patch is made from; times as in the patch.
struct Original {
  std::vector<model::Point4> vertices;
  std::vector<model::Cell> cells;
};

Original originalOf(const Patch& patch);
/// Both together.
Original joined(Original one, const Original& other);

/// `collapsed`, such that no slice is farther than `maxError` from that of the original at the same
/// time, nor the other way round: where that cannot be proved (measure::SliceBound), the last
/// collapses are left out. The patch given must be near enough itself, and have samples.
Patch provedCollapse(const Patch& given, const Original& original, double maxError,
                     const CollapseOptions& options);

}  // namespace t4d::edit
