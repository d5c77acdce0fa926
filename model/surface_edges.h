#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "model/union_find.h"
#include "t4d/mesh.h"
#include "t4d/surface.h"

/// How the triangles of a surface meet at its edges, for surfaces of any kind: open, with three or
/// more triangles at an edge, with orientations that disagree.
namespace t4d::model {

/// The sides of triangles at one edge. A side is 3 * triangle + the corner that it starts from.
struct EdgeSides {
  std::uint32_t low;   ///< the smaller vertex
  std::uint32_t high;  ///< the larger
  std::uint32_t begin;
  std::uint32_t end;  ///< its sides are sides[begin] .. sides[end - 1]
};

struct SurfaceEdges {
  std::vector<std::uint32_t> sides;
  std::vector<EdgeSides> edges;  ///< in the order of their vertices
};

/// Finds the edges of triangles, and at each of them its sides in ascending order.
SurfaceEdges edgesOf(std::span<const Triangle> triangles);

/// The side of the same triangle that starts where this one ends.
inline std::uint32_t nextSide(std::uint32_t side) { return side % 3 == 2 ? side - 2 : side + 1; }

inline std::uint32_t fromOf(const TriangleMesh& mesh, std::uint32_t side) {
  return mesh.triangles[side / 3][side % 3];
}
inline std::uint32_t toOf(const TriangleMesh& mesh, std::uint32_t side) {
  return mesh.triangles[side / 3][(side + 1) % 3];
}
inline std::uint32_t apexOf(const TriangleMesh& mesh, std::uint32_t side) {
  return mesh.triangles[side / 3][(side + 2) % 3];
}

/// Whether a side leads from the smaller vertex of its edge to the larger.
inline bool isForward(const TriangleMesh& mesh, std::uint32_t side) {
  return fromOf(mesh, side) < toOf(mesh, side);
}

/// Unites the corners of two sides of one edge, at both ends of it. A corner has the number of the
/// side that starts from it.
inline void uniteCorners(UnionFind& corners, const TriangleMesh& mesh, std::uint32_t a,
                         std::uint32_t b) {
  const bool same = fromOf(mesh, a) == fromOf(mesh, b);
  corners.unite(a, same ? b : nextSide(b));
  corners.unite(nextSide(a), same ? nextSide(b) : b);
}

/// For each side, the side of the triangle where its surface continues; kNoIndex at a boundary.
/// Where an even number of triangles, more than two, meet at an edge, those with solid between them
/// are mates if as many traverse the edge in one direction as in the other; otherwise neighbours
/// around the edge are mates. Of an odd number above two, none are mates. No triangle may have a
/// corner twice.
std::vector<std::uint32_t> matesOf(const TriangleMesh& mesh, const SurfaceEdges& edges);

/// The closed paths along which the surface is open, each as its vertices in the direction of its
/// triangles; no path visits a vertex twice. Sides that cancel each other at an edge do not count
/// as open.
std::vector<std::vector<std::uint32_t>> boundaryLoops(const TriangleMesh& mesh,
                                                      const SurfaceEdges& edges);

}  // namespace t4d::model
