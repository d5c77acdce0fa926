#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "model/exact_sum.h"
#include "t4d/mesh.h"

namespace t4d::measure {

/// The contribution of a slab to the measures of its mesh.
struct SlabMeasure {
  double hypervolume = 0;     ///< enclosed between the slab's times
  int sign = 0;               ///< its sign, also where it is beyond the range of doubles
  double boundaryVolume = 0;  ///< 3-measure of its cells
  /// Cells without volume: those that can become flat if their corners move by `rounding`.
  std::vector<std::uint32_t> flat;
};

/// Measures a sound slab, on all threads; `rounding` is a distance along each axis. The result does
/// not depend on the number of threads.
///
/// The hypervolume is the flux of (x, y, z, 0) / 3 through the cells, by the divergence theorem.
/// Unlike the sum of det[a, b, c, d] / 24, which is the same for a whole mesh, none of it passes
/// through the layers, so a slab can be measured about an origin of its own. Where the terms cancel
/// so far that too few digits are left, as for a small solid that moves far, or are beyond the
/// range of doubles, they are added up without rounding (model::ExactSum).
SlabMeasure measureOf(const model::Slab& slab, const model::Point4& rounding);

/// The sign of what closed cells enclose, the sum of det[a, b, c, d] about the first vertex: right
/// for any finite coordinates. 0 if they enclose exactly nothing.
int hypervolumeSign(std::span<const model::Point4> vertices, std::span<const model::Cell> cells);

}  // namespace t4d::measure
