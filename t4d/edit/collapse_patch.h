#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "t4d/edit/patch.h"
#include "t4d/measure/slice_bound.h"

namespace t4d::edit {

/// The least height of a cell, divided by its longest edge (measure::CellQuality::height), that a
/// collapse may make, unless a cell that it replaces is worse.
inline constexpr double kLeastHeight = 0.01;

/// Vertex b joins a, at the place that a pull towards one of several points gives.
struct Collapse {
  std::uint32_t a;
  std::uint32_t b;
  std::uint32_t pull;
};

struct CollapseOptions {
  std::uint64_t cells = 0;  ///< stop at this number
  double firstTime = 0;     ///< of the whole mesh, as a length
  double lastTime = 0;
  std::string preserve = {};  ///< a cell attribute whose values keep their borders; "" for none
  const measure::SliceBound* original = nullptr;  ///< to which vertices with a reach stay near
  /// Only these, in this order, as far as each is possible; null for those that cost least.
  const std::vector<Collapse>* only = nullptr;
};

/// What came of the vertices of the patch that was given.
struct CollapsedPatch {
  Patch patch;
  std::vector<std::uint32_t> vertexOf;  ///< the vertex of `patch` that each has
                                        ///< become; CellComplex::kNone if no cell had it
  std::vector<Collapse> collapses;      ///< of vertices of the patch given, in order
};

/// Collapses edges, those that change the shape least first, as long as the mesh stays the same
/// 3-manifold and slices keep their topology, each collapse keeps the hypervolume, no cell turns by
/// more than 70 degrees, none becomes a needle (kLeastHeight), and no sample is farther from the
/// cells than the reaches of their vertices, nor a vertex from the original.
///
/// Vertices of the first and the last layer of the patch stay as they are. Those of the seam, of
/// cells at one time, at the first and at the last time, and those where the topology of slices
/// changes keep their time. Of a patch with a seam, only edges that end there are collapsed.
CollapsedPatch collapsed(Patch patch, const CollapseOptions& options);

}  // namespace t4d::edit
