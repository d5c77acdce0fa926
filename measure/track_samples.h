#pragma once

#include "measure/component_history.h"

namespace t4d::measure {

/// Adds the measures of a slice to the tracks of its surfaces.
void addSample(const SlabShells& current, const ArcMeasures& sample, ComponentHistory& history);

/// Gives tracks that are not measured while they exist, as far as is known, a volume: that at their
/// begin or, of those that appear, at the vertex of this slab next to the middle of their time.
/// `atNext`: its last layer is measured.
void addUnsampled(SlabShells& current, bool atNext, ComponentHistory& history);

}  // namespace t4d::measure
