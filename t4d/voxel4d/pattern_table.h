#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

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
/// det[n, b-a, c-a, d-a] > 0 for n from inside to outside.
class PatternTable {
 public:
  using Tetrahedron = std::array<std::uint8_t, 4>;

  /// Computed on first use by exact integer arithmetic, in a fraction of a second. Half a megabyte
  /// of numbers in the source would be no easier to trust than the 200 lines that compute them.
  static const PatternTable& get();

  std::span<const Tetrahedron> tetrahedra(unsigned pattern) const {
    return std::span(tetrahedra_).subspan(first_[pattern], first_[pattern + 1] - first_[pattern]);
  }
  /// Bit e is set if edge e joins an inside to an outside corner; tetrahedra use only such edges.
  std::uint32_t edges(unsigned pattern) const { return edges_[pattern]; }
  std::uint32_t count(unsigned pattern) const { return first_[pattern + 1] - first_[pattern]; }

  /// The number of classes of patterns up to symmetries of the hypercube: 402.
  int classCount() const { return classCount_; }

 private:
  PatternTable();

  std::vector<std::uint32_t> first_;
  std::vector<std::uint32_t> edges_;
  std::vector<Tetrahedron> tetrahedra_;
  int classCount_ = 0;
};

}  // namespace t4d::voxel4d
