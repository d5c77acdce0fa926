#pragma once

#include <cstdint>
#include <vector>

#include "t4d/model/slab.h"

/// The link of a vertex is the surface made by the facets opposite it in its cells. The mesh is a
/// 3-manifold where every link is a sphere.
namespace t4d::measure {

/// The interior vertices of a slab that have cells and whose link is not one sphere.
std::vector<std::uint32_t> interiorVerticesWithoutSphere(const model::Connectivity& connectivity);

/// The same for the vertices of the layer between two slabs, counted from the layer's first. Either
/// may be null, at the ends of the mesh.
std::vector<std::uint32_t> layerVerticesWithoutSphere(const model::Connectivity* before,
                                                      const model::Connectivity* after);

}  // namespace t4d::measure
