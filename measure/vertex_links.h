#pragma once

#include <cstdint>
#include <vector>

#include "t4d/mesh.h"

/// The link of a vertex is the surface made of the facets opposite it in its cells. A vertex whose
/// link is not a sphere is non-manifold; a mesh without such a vertex is a 3-manifold.
namespace t4d::measure {

/// The non-manifold interior vertices of a slab, ignoring those without cells.
std::vector<std::uint32_t> nonManifoldInteriorVertices(const model::Connectivity& connectivity);

/// The non-manifold vertices of the layer between two slabs, numbered from the first of the layer.
/// Either slab may be null, at an end of the mesh.
std::vector<std::uint32_t> nonManifoldLayerVertices(const model::Connectivity* before,
                                                    const model::Connectivity* after);

}  // namespace t4d::measure
