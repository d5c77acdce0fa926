#pragma once

#include <cstdint>
#include <optional>

#include "formats/mesh4d/mesh4d.h"
#include "model/slab.h"

namespace t4d::edit {

struct SlabCuts {
  /// The number of slabs. Tetrahedra that span a cut are split there. There are fewer slabs if the
  /// vertices have too few times. Without this, the mesh is cut only where no tetrahedron is split,
  /// into slabs of at least some hundred tetrahedra, so a swept mesh gets its layers back.
  std::optional<std::uint64_t> slabs = {};
};

struct CutMesh {
  model::Mesh mesh;
  std::uint64_t splitTetrahedra = 0;  ///< tetrahedra that spanned a cut
  std::uint64_t newVertices = 0;
};

/// Cuts a closed mesh into slabs at times of its own vertices. Where an edge crosses a cut it gets
/// a new vertex, which all its tetrahedra share, at exactly that time (CellSplitter). The solid
/// stays the same: hypervolume and slices change by no more than the rounding of the new vertices.
///
/// Fails if two tetrahedra that would be split have the same corners.
Result<CutMesh> cutIntoSlabs(formats::Mesh4d mesh, const SlabCuts& cuts = {});

}  // namespace t4d::edit
