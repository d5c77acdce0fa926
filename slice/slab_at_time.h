#pragma once

#include <cstddef>
#include <optional>

#include "t4d/mesh.h"

namespace t4d::slice {

/// The slab to slice for a time.
struct SlabAtTime {
  double time = 0;  ///< the time that the given one refers to (model::timeWithin)
  /// True at the last time of the mesh, where the slice is the limit from earlier times.
  bool atEnd = false;
  /// The slab to slice; nothing in a gap between runs of slabs, where the slice is empty.
  std::optional<std::size_t> slab;
};

/// Fails if the time is outside the mesh, and if the mesh has no slabs.
Result<SlabAtTime> slabAtTime(const model::Source& source, double given);

}  // namespace t4d::slice
