#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "t4d/mesh.h"

namespace t4d::formats {

/// Splits a convex polyhedron into tetrahedra by pulling it from its smallest vertex v: each face
/// without v is split into triangles from its own smallest vertex, and each triangle joined to v.
///
///      3-------2        v = 0: the face 1 2 5 4 becomes the triangles (1, 2, 5) and (1, 5, 4),
///     /|      /|        which with 0 make two tetrahedra
///    0-------1 |
///    | 7-----|-6        A face with v is thereby split from v, its smallest vertex, too: so the
///    |/      |/         two polyhedra that share a face split it in the same way.
///    4-------5
///
/// `faces` are the numbers of the corners of each face in order around it; the direction does not
/// matter. Calls back for each tetrahedron (v, a, b, c), where (a, b, c) are in the direction of
/// their face.
void pullPolyhedron(std::span<const std::span<const std::uint32_t>> faces,
                    const std::function<void(const model::Cell&)>& take);

}  // namespace t4d::formats
