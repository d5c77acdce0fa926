#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "t4d/model/error.h"
#include "t4d/model/triangle_mesh.h"

namespace t4d::edit {

/// The triangles that close a hole without new vertices. `loop` are its vertices in the direction
/// of the triangles around it, at least three, none twice; the new triangles traverse it the other
/// way. `apexes[i]` is the third vertex of the triangle at the side from loop[i] to the next. The
/// least dihedral angles, with those triangles, too, and area of all ways through the Delaunay
/// triangulation of the loop's points (CGAL, after Liepa 2003); where that has no way, such as for
/// points on one line, the least area. They may cross the rest of the mesh.
///
/// Fails if CGAL finds no way for a loop of more than kMostSides.
Result<std::vector<model::Triangle>> fillHole(const model::TriangleMesh& mesh,
                                              std::span<const std::uint32_t> loop,
                                              std::span<const std::uint32_t> apexes);

/// Finding the least area takes time in proportion to the third power.
inline constexpr std::size_t kMostSides = 400;

}  // namespace t4d::edit
