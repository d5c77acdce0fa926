#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "mesh4d/step_crossings.h"
#include "t4d/error.h"
#include "t4d/surface.h"

namespace t4d::edit {

struct SurfaceCrossings {
  std::vector<std::uint32_t> flat;  ///< triangles without area
  /// Pairs of other triangles, the smaller number first, that have more in common than shared
  /// vertices and edges: they cross, touch or overlap.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  bool complete = true;  ///< false if there are more than `most` pairs

  bool none() const { return flat.empty() && pairs.empty(); }
};

/// Whether findCrossings works; false in a build without CGAL.
bool findsCrossings();

/// Finds where a surface meets itself, by exact predicates. The surface may be open and need not be
/// a manifold, but no two vertices may have equal coordinates.
///
/// Fails unless findsCrossings().
Result<SurfaceCrossings> findCrossings(const model::TriangleMesh& mesh, std::size_t most);

/// The same for these triangles alone: those that are flat, and all pairs that one of them is in.
Result<SurfaceCrossings> findCrossingsOf(std::span<const std::uint32_t> triangles,
                                         const model::TriangleMesh& mesh);

/// Calls mesh4d::crossingOf. Fails unless findsCrossings().
Result<std::optional<mesh4d::StepCrossing>> crossingWithin(const model::TriangleMesh& mesh,
                                                           const model::Slab& step);

}  // namespace t4d::edit
