#pragma once

#include <array>
#include <cstdint>
#include <span>

/// The table of 4D marching cubes, after Bhaniramka, Wenger and Crawfis ("Isosurface construction
/// in any dimension using convex hulls", 2004), which the paper's ref. [3] and [12] are based on.
///
/// A hypercube has 16 corners, each inside or outside. Corner b has the coordinates
///
///     x = b & 1,   y = b >> 1 & 1,   z = b >> 2 & 1,   t = b >> 3 & 1,
///
/// and bit b of a *pattern* says whether it is inside:
///
///            6 ------- 7                 14 ------- 15
///           /|        /|                 /|        /|
///          4 ------- 5 |     later      12 ------- 13
///     z    | |       | |   --------->   | |        | |
///     | y  | 2 ------| 3       t        | 10 ------| 11
///     |/   |/        |/                 |/         |/
///     +--x 0 ------- 1                  8 -------- 9
///
/// It has 32 edges. Edge 8 a + r runs along axis a (x, y, z, t) from a corner whose bit a is 0; r
/// is that corner's number with bit a removed. So edges 0-7 run along x, 8-15 along y, 16-23 along
/// z and 24-31 along t.
///
/// For each pattern take the convex hull of the inside corners and of the midpoints of the edges
/// that join an inside to an outside corner. The hull's facets (3-polytopes) that do not lie on the
/// hypercube's boundary are the patch: the surface within this hypercube. Their vertices are
/// midpoints of edges only. Each polytope is cut into tetrahedra by pulling: its smallest vertex is
/// joined to the triangles of the 2-faces that do not contain it, and each 2-face is fanned from
/// its own smallest vertex. "Smallest" refers to the lexicographic order of all points of the
/// lattice. That order is the same seen from any hypercube, so neighbours divide their common faces
/// alike, and the whole surface is closed.
namespace t4d::voxel4d {

inline constexpr int kCorners = 16;
inline constexpr int kEdges = 32;
inline constexpr int kPatterns = 65536;

/// The corner of edge e whose coordinate along the edge is 0, and the edge's axis (0 to 3).
constexpr int edgeAxis(int edge) { return edge / 8; }
constexpr int edgeCorner(int edge) {
  const int axis = edge / 8;
  const int rest = edge % 8;
  const int low = (1 << axis) - 1;
  return (rest & low) | (rest & ~low) << 1;
}

/// The surface in a hypercube for each pattern: tetrahedra whose vertices are edges, oriented with
/// det[n, b-a, c-a, d-a] > 0 for n from inside to outside. Each edge joins an inside to an outside
/// corner. The table is computed when the library is built (pattern_patches.h).
class PatternTable {
 public:
  using Tetrahedron = std::array<std::uint8_t, 4>;

  static std::span<const Tetrahedron> tetrahedra(unsigned pattern);
  static std::uint32_t count(unsigned pattern);
  /// Bit e is set if edge e joins an inside to an outside corner.
  static constexpr std::uint32_t edges(unsigned pattern) {
    std::uint32_t edges = 0;
    for (int edge = 0; edge < kEdges; ++edge) {
      const int corner = edgeCorner(edge);
      const int other = corner | 1 << edgeAxis(edge);
      edges |= ((pattern >> corner ^ pattern >> other) & 1U) << edge;
    }
    return edges;
  }
};

}  // namespace t4d::voxel4d
