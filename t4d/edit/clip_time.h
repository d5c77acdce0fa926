#pragma once

#include <cstdint>
#include <vector>

#include "t4d/edit/close_runs.h"
#include "t4d/model/slab.h"

namespace t4d::edit {

struct TimeClip {
  std::uint64_t slabs = 0;     ///< of the part, without caps
  std::uint64_t cells = 0;     ///< likewise
  std::uint64_t cutSlabs = 0;  ///< that reached over an end of the span
  std::vector<RunEnd> caps;    ///< that close the part, in time order
};

/// Puts the part of a closed 4D mesh that lies within `span`, with begin < end, into `sink`, and
/// closes it by caps (RunCloser): the solid is the same at every time of the span, and does not
/// exist outside. Slabs within the span stay as they are. Of one that reaches over an end of the
/// span, the cells are split there (CellSplitter), so hypervolume and slices change by no more than
/// the rounding of the new vertices; vertex attributes are interpolated along edges as those of
/// slices are, cell attributes are those of the cell. Reads only slabs that the span meets, one at
/// a time, and puts nothing if there are none.
///
/// Fails if the mesh is open at an end of the span, or if two cells to be split have the same
/// corners.
Result<TimeClip> clipTime(const model::Source& source, const model::TimeSpan& span,
                          model::Sink& sink, const model::Progress& progress = {});

}  // namespace t4d::edit
