#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "t4d/error.h"
#include "t4d/surface.h"

namespace t4d::edit {

/// Returns triangles that close a hole without new vertices. `loop` has its vertices in the
/// direction of the triangles around it, at least three, none twice; the new triangles traverse it
/// in the opposite direction. `apexes[i]` is the third vertex of the triangle at the side from
/// loop[i] to the next. Of all triangulations within the Delaunay triangulation of the loop's
/// points, the result has the least dihedral angles, including those with the triangles around the
/// hole, and area (CGAL, after Liepa 2003). If there is none, for example for points on one line,
/// the result has the least area. It may cross the rest of the mesh.
///
/// Fails if CGAL finds no triangulation of a loop with more than kMostSides sides.
Result<std::vector<model::Triangle>> fillHole(const model::TriangleMesh& mesh,
                                              std::span<const std::uint32_t> loop,
                                              std::span<const std::uint32_t> apexes);

/// The largest loop that is filled with the least area, which takes time proportional to its third
/// power.
inline constexpr std::size_t kMostSides = 400;

}  // namespace t4d::edit
