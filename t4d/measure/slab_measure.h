#pragma once

#include <cstdint>
#include <functional>

#include "t4d/model/slab.h"

namespace t4d::measure {

/// What a slab adds to the measures of its mesh.
struct SlabMeasure {
  double hypervolume = 0;     ///< enclosed between the slab's times
  double boundaryVolume = 0;  ///< 3-measure of its cells
};

/// Measures a sound slab, and calls `flat` with the number of each cell without volume: one that
/// can become flat if its corners move by `rounding`, a distance along each axis.
///
/// The hypervolume is the flux of (x, y, z, 0) / 3 through the cells, by the divergence theorem.
/// Unlike the sum of det[a, b, c, d] / 24, which is the same for a whole mesh, none of it passes
/// through the layers, so a slab can be measured about an origin of its own. Where the terms cancel
/// so far that too few digits are left, as for a small solid that moves far, they are computed
/// again with 113 bits.
SlabMeasure measureOf(const model::Slab& slab, const model::Point4& rounding,
                      const std::function<void(std::uint32_t)>& flat);

}  // namespace t4d::measure
