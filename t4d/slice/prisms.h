#pragma once

#include <cstdint>
#include <vector>

#include "t4d/model/slab.h"
#include "t4d/model/triangle_mesh.h"

namespace t4d::slice {

/// The triangles whose prisms a slab is made of, in the order of their first cells.
struct Prisms {
  /// Of vertices of the lower layer, facing outward; the upper layer has the same triangles.
  std::vector<model::Triangle> triangles;
  std::vector<std::uint32_t> prismOf;  ///< for each cell
  std::vector<std::uint32_t> bottoms;  ///< for each triangle, the cell that has it
};

/// Finds the prisms of 14 cells that a triangle mesh sweeps in a step (mesh4d/prism.h; the paper,
/// section 4.1) in the cells and means alone, whoever made them: both layers have the same number
/// of vertices, and the cells around each mean of six vertices are those over the triangle below,
/// the one above it, and the three quadrilaterals between, each in four triangles about its mean.
/// Fails, saying why, if any cell belongs to none. `connectivity` has passed checkConnectivity.
Result<Prisms> prismsOf(const model::Connectivity& connectivity);

}  // namespace t4d::slice
