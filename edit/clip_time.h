#pragma once

#include <cstdint>
#include <vector>

#include "t4d/edit.h"
#include "t4d/mesh.h"

namespace t4d::edit {

struct TimeClip {
  std::uint64_t slabs = 0;     ///< of the part, without caps
  std::uint64_t cells = 0;     ///< of the part, without caps
  std::uint64_t cutSlabs = 0;  ///< slabs that were cut at an end of the span
  std::vector<RunEnd> caps;    ///< the caps that close the part, in time order
};

/// Puts the part of a closed 4D mesh within `span`, with begin < end, into `sink`, and closes it by
/// caps (RunCloser): the solid is the same at every time of the span, and does not exist outside.
/// Slabs within the span are not changed. If a slab extends over an end of the span, its cells are
/// split there (CellSplitter), so hypervolume and slices change by no more than the rounding of the
/// new vertices. Vertex attributes are interpolated along edges, as in slices; parts of a cell keep
/// its attributes. Reads only slabs that meet the span, one at a time, and puts nothing if there
/// are none.
///
/// Fails if the mesh is open at an end of the span, or if two cells to be split have the same
/// corners.
Result<TimeClip> clipTime(const model::Source& source, const model::TimeSpan& span,
                          model::Sink& sink, const model::Progress& progress = {});

}  // namespace t4d::edit
