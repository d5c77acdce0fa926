#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <string>

#include "model/part.h"
#include "model/slab.h"

namespace t4d::edit {

struct SimplifyOptions {
  /// The fraction of the cells to keep: above 0, at most 1.
  std::optional<double> ratio = {};
  /// The maximum distance of slices from those of the given mesh, in length units.
  std::optional<double> maxError = {};
  /// The length that one unit of time counts as, to weigh errors in space and time. It is rounded
  /// to a power of two, so that times keep their bits.
  double timeScale = 1;
  /// The name of a cell attribute; borders between cells with different values are kept. "" for
  /// none.
  std::string preserve = {};
  /// The number of slabs that become one; by default enough for some hundred thousand cells.
  std::optional<std::uint64_t> windowSlabs = {};
  /// Simplifies only some of the windows. Layers where parts meet are not changed, so parts
  /// simplified with the same options fit together (formats::joinT4d).
  model::Part part = {};
};

/// For a part, the numbers are those of its slabs only.
struct SimplifyReport {
  std::array<std::size_t, 2> slabs = {};  ///< first slab of the source, and one past the last
  std::uint64_t cellsBefore = 0;
  std::uint64_t cells = 0;
  std::uint64_t verticesBefore = 0;
  std::uint64_t vertices = 0;
  double hypervolumeBefore = 0;
  double hypervolume = 0;
  /// A bound on the Hausdorff distance between slices of the result and of the given mesh at the
  /// same time; at most SimplifyOptions::maxError. Nothing without this option.
  std::optional<double> maxError = {};
  std::set<std::string> droppedAttributes = {};  ///< names of attributes that only some slabs have
};

/// Puts a closed 4D mesh with fewer cells into `sink`: edges are collapsed, first those that change
/// the shape least (collapsed). The result is the same 3-manifold and lasts as long. Its
/// hypervolume is the same up to rounding, and the topology of its slices changes at the same
/// times. With a maximum error, it is proved that slices stay within it (provedCollapse), which
/// takes many times as long. Vertex attributes are interpolated along edges; remaining cells keep
/// their attributes.
///
/// Slabs are grouped into windows, each of which becomes one slab; a slab without thickness is a
/// window of its own. Each window is simplified except for its first and last layer; then each
/// layer between two windows, with the cells on both sides. Two windows, and one more for each
/// thread, are in memory. The result does not depend on the number of threads.
///
/// Reads the mesh, or its part, twice. Fails for a mesh that is not closed, oriented and manifold
/// (except at the apex of a conical cap), for contradictory options, and for more parts than
/// windows.
Result<SimplifyReport> simplify(const model::Source& source, const SimplifyOptions& options,
                                model::Sink& sink, const model::Progress& progress = {});

}  // namespace t4d::edit
