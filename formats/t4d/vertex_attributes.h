#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "t4d/error.h"
#include "t4d/mesh.h"

namespace t4d::formats {

/// The lower layer of a slab, the interior vertices that are not means, and the upper layer.
using PartAttributes = std::array<std::vector<model::Attribute>, 3>;

/// The vertex attributes of a slab, of which each part has the rows of its own vertices (SPEC.md,
/// section "Putting a slab together"). Fails if parts that have vertices have different ones, and
/// if what means inherit takes more than `maxInherited` bytes: a small file could request any
/// number.
Result<std::vector<model::Attribute>> joinedAttributes(const model::Connectivity& connectivity,
                                                       const PartAttributes& parts,
                                                       std::uint64_t maxInherited);

/// Checks the vertex attributes of a slab to be written: those of its lower layer, which must equal
/// those of the upper layer of the slab before (null for the first slab), and those of means.
Result<void> checkVertexAttributes(const model::Slab& slab,
                                   const std::vector<model::Attribute>* upperBefore);

}  // namespace t4d::formats
