#pragma once

#include <cstdint>
#include <vector>

#include "t4d/edit.h"
#include "t4d/mesh.h"

namespace t4d::edit {

/// A component of a solid that was cut out, from its begin to its end.
struct TrackCut {
  model::TimeSpan span;
  std::uint64_t slabs = 0;     ///< without caps
  std::uint64_t cells = 0;     ///< without caps
  std::uint64_t cutSlabs = 0;  ///< slabs that were cut at its begin or its end
  std::vector<RunEnd> caps;    ///< the caps that close it, in time order
};

/// Puts a track of a closed mesh, by its number (measure::tracksOf, nothing pruned), into `sink`:
/// the component of the solid, with its cavities, through its life. Where it begins or ends in an
/// event that others take part in, it is closed there by a cap over its own section (RunCloser).
/// If that section touches itself, as where a solid splits at a point, what touches is separated
/// (separateTouching). Cells that lie in its first or its last time are replaced by caps, too.
///
/// Cells that span the begin or the end are split there (CellSplitter), others are not changed; so
/// hypervolume and slices are those of the component in the mesh, up to the rounding of new
/// vertices. Attributes are as clipTime leaves them. Reads all slabs up to the end of the track,
/// each once, and has two in memory.
///
/// Fails if there is no such track, and as clipTime does.
Result<TrackCut> cutTrack(const model::Source& source, std::uint32_t track, model::Sink& sink,
                          const model::Progress& progress = {});

}  // namespace t4d::edit
