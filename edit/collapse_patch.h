#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "edit/patch.h"
#include "measure/slice_bound.h"

namespace t4d::edit {

/// The least height of a cell, divided by its longest edge (measure::CellQuality::height), that a
/// collapse may make, unless a cell that it replaces is worse.
inline constexpr double kLeastHeight = 0.01;

/// A collapse: vertex b joins a, at the position given by a pull towards one of several points.
struct Collapse {
  std::uint32_t a;
  std::uint32_t b;
  std::uint32_t pull;
};

struct CollapseOptions {
  std::uint64_t cells = 0;  ///< stop at this number
  double firstTime = 0;     ///< of the whole mesh, as a length
  double lastTime = 0;
  std::string preserve = {};  ///< a cell attribute whose borders are kept; "" for none
  const measure::SliceBound* original = nullptr;  ///< vertices with a reach stay near it
  /// If set, only these collapses are made, in this order, if possible; otherwise those with the
  /// least cost.
  const std::vector<Collapse>* only = nullptr;
};

/// The collapsed patch, and what became of the vertices of the given one.
struct CollapsedPatch {
  Patch patch;
  std::vector<std::uint32_t> vertexOf;  ///< the vertex of `patch` that each has
                                        ///< become; model::kNoIndex if no cell had it
  std::vector<Collapse> collapses;      ///< of vertices of the given patch, in order
};

/// Collapses edges, first those that change the shape least. The mesh stays the same 3-manifold,
/// slices keep their topology, and each collapse keeps the hypervolume. No cell turns by more than
/// 70 degrees or becomes a needle (kLeastHeight). No sample is farther from the cells than the
/// reaches of their vertices, and no vertex farther from the original than its reach.
///
/// Vertices of the first and the last layer of the patch stay as they are. Vertices of the seam, of
/// cells at one time, at the first and at the last time, and those where the topology of slices
/// changes, keep their time. If the patch has a seam, only edges that end there are collapsed.
CollapsedPatch collapsed(Patch patch, const CollapseOptions& options);

}  // namespace t4d::edit
