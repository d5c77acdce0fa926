#pragma once

#include <cstdint>
#include <vector>

#include "t4d/mesh.h"
#include "t4d/surface.h"

namespace t4d::slice {

/// The triangles whose prisms a slab is made of, in the order of their first cells.
struct Prisms {
  /// Their vertices are those of the lower layer. They face outward. The upper layer has the same
  /// triangles.
  std::vector<model::Triangle> triangles;
  std::vector<std::uint32_t> prismOf;  ///< for each cell
  std::vector<std::uint32_t> bottoms;  ///< for each triangle, the cell over it
};

/// Finds the prisms of 14 cells that a triangle mesh sweeps in a step (mesh4d/prism.h; the paper,
/// section 4.1). It looks only at the cells and means, whichever program made them: both layers
/// have the same number of vertices, and the cells around each mean of six vertices are those over
/// the triangle below, the one above it, and the three quadrilaterals between them, each in four
/// triangles about its mean. Fails, with the reason, if any cell belongs to no prism.
/// `connectivity` has passed checkConnectivity.
Result<Prisms> prismsOf(const model::Connectivity& connectivity);

}  // namespace t4d::slice
