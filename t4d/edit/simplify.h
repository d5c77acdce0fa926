#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <string>

#include "t4d/model/part.h"
#include "t4d/model/slab.h"

namespace t4d::edit {

struct SimplifyOptions {
  /// The number of cells to keep, as a part of those there are: above 0, at most 1.
  std::optional<double> ratio = {};
  /// How far slices may be from those of the mesh given, in length units.
  std::optional<double> maxError = {};
  /// A length for each unit of time, by which errors in space and time are weighed. The nearest
  /// power of two is taken, so that times keep their bits.
  double timeScale = 1;
  /// The name of a cell attribute; borders between cells of different values stay. "" for none.
  std::string preserve = {};
  /// The slabs that become one; without it, as many as have some hundred thousand cells.
  std::optional<std::uint64_t> windowSlabs = {};
  /// Only some of the windows. Layers where parts meet stay as they are, so parts that are
  /// simplified with the same options fit together (formats::joinT4d).
  model::Part part = {};
};

/// Of a part: of its slabs alone.
struct SimplifyReport {
  std::array<std::size_t, 2> slabs = {};  ///< of the source: from this up to, not including, that
  std::uint64_t cellsBefore = 0;
  std::uint64_t cells = 0;
  std::uint64_t verticesBefore = 0;
  std::uint64_t vertices = 0;
  double hypervolumeBefore = 0;
  double hypervolume = 0;
  /// No slice is farther than this from that of the mesh given at the same time, nor the other way
  /// round; at most SimplifyOptions::maxError. Nothing without that.
  std::optional<double> maxError = {};
  std::set<std::string> droppedAttributes = {};  ///< names of those that only some slabs have
};

/// Puts a closed 4D mesh with fewer cells into `sink`: edges are collapsed, those first that change
/// the shape least (collapsed). The result is the same 3-manifold and lasts as long, its
/// hypervolume is the same up to rounding, and the topology of slices changes at the same times.
/// With a largest error, it is proved that slices stay within it (provedCollapse), which takes many
/// times as long. Attributes of vertices are interpolated along edges; cells that remain keep
/// theirs.
///
/// Slabs are put together to windows, each of which becomes one slab; those without thickness stay
/// alone. A window is simplified but for its first and last layer; then each layer with what lies
/// on both sides of it. So two windows, and one more for each thread, are in memory. The result
/// does not depend on the number of threads.
///
/// Reads the mesh, or its part, twice. Fails for one that is not closed, oriented and manifold,
/// unless it is so at the apex of a cap that is a cone, for options that contradict themselves, and
/// for more parts than windows.
Result<SimplifyReport> simplify(const model::Source& source, const SimplifyOptions& options,
                                model::Sink& sink, const model::Progress& progress = {});

}  // namespace t4d::edit
