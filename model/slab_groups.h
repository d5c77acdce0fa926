#pragma once

#include <cstddef>
#include <vector>

#include "t4d/mesh.h"

namespace t4d::model {

/// Consecutive slabs of a source, `first` to `end - 1`.
struct SlabGroup {
  std::size_t first = 0;
  std::size_t end = 0;
  TimeSpan time;   ///< from the first slab's begin to the last one's end
  Bounds3 bounds;  ///< of all their vertices
};

/// What a Source is, too, that has not read the times of all its slabs yet: a file in parts, or one
/// with pages of its index. Asking for the time of a slab reads its group, which these functions
/// avoid where they can.
///
/// Slab::timeSpan cannot fail: if a group cannot be read, each of its slabs has the time and the
/// bounds of the group, so that none is passed over, and reading the slab gives the error.
class GroupedSource {
 public:
  virtual ~GroupedSource() = default;
  /// The groups of all slabs, in order; none is empty.
  virtual const std::vector<SlabGroup>& groups() const = 0;
};

/// The groups of a source; none if it has the times of all slabs at hand.
const std::vector<SlabGroup>& slabGroupsOf(const Source& source);

/// The number of the first slab that ends later than `time` or, with `orThen`, at it; slabCount()
/// if there is none.
std::size_t firstSlabEndingAfter(const Source& source, double time, bool orThen = false);

/// The end of a slab. For the last slab of a group, nothing is read.
double endOfSlab(const Source& source, std::size_t index);

}  // namespace t4d::model
