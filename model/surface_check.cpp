#include "model/surface_check.h"

#include <algorithm>

#include <fmt/format.h>

#include "model/surface_edges.h"
#include "model/union_find.h"
#include "t4d/mesh.h"

namespace t4d::model {
namespace {

std::string textOf(const Point3& point) {
  return fmt::format("({}, {}, {})", point.x(), point.y(), point.z());
}

Result<void> checkElements(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return invalid("the mesh has no triangles");
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (!mesh.vertices[i].allFinite()) {
      return invalid(
          fmt::format("vertex {} is {}; coordinates must be finite", i, textOf(mesh.vertices[i])));
    }
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& [a, b, c] = mesh.triangles[i];
    const std::uint32_t largest = std::max({a, b, c});
    if (largest >= mesh.vertices.size()) {
      return invalid(fmt::format("triangle {} has the vertex {}, but there are only {}", i, largest,
                                 mesh.vertices.size()));
    }
    if (a == b || b == c || c == a) {
      return invalid(fmt::format("triangle {} ({}, {}, {}) has a corner twice", i, a, b, c));
    }
  }
  return {};
}

/// Checks that each edge has exactly two triangles, which traverse it in opposite directions and
/// are not each other's reverse.
Result<void> checkEdges(const TriangleMesh& mesh, const SurfaceEdges& edges) {
  std::size_t open = 0;
  std::size_t nonManifold = 0;
  std::size_t inconsistent = 0;
  const EdgeSides* firstOpen = nullptr;
  const EdgeSides* firstNonManifold = nullptr;
  const EdgeSides* firstInconsistent = nullptr;
  const EdgeSides* firstDoubled = nullptr;
  for (const EdgeSides& edge : edges.edges) {
    const auto note = [&](std::size_t& count, const EdgeSides*& first) {
      ++count;
      if (first == nullptr) first = &edge;
    };
    const std::uint32_t* sides = &edges.sides[edge.begin];
    if (edge.end - edge.begin == 1) {
      note(open, firstOpen);
    } else if (edge.end - edge.begin > 2) {
      note(nonManifold, firstNonManifold);
    } else if (isForward(mesh, sides[0]) == isForward(mesh, sides[1])) {
      note(inconsistent, firstInconsistent);
    } else if (firstDoubled == nullptr && apexOf(mesh, sides[0]) == apexOf(mesh, sides[1])) {
      firstDoubled = &edge;
    }
  }
  const auto triangleAt = [&](const EdgeSides& edge, std::uint32_t i) {
    return edges.sides[edge.begin + i] / 3;
  };
  const auto place = [&](const EdgeSides& edge) {
    return fmt::format("edge {}-{} at {} to {}", edge.low, edge.high,
                       textOf(mesh.vertices[edge.low]), textOf(mesh.vertices[edge.high]));
  };
  if (open > 0) {
    return invalid(
        fmt::format("the mesh is open: {} boundary edges, the first of triangle {}, {}; a "
                    "solid needs a closed surface",
                    open, triangleAt(*firstOpen, 0), place(*firstOpen)),
        {}, Remedy::Mend);
  }
  if (nonManifold > 0) {
    const EdgeSides& first = *firstNonManifold;
    return invalid(
        fmt::format(
            "the mesh has {} non-manifold edge{}, with more than two triangles; the first is "
            "{} (triangles {}, {}, {}{})",
            nonManifold, nonManifold == 1 ? "" : "s", place(first), triangleAt(first, 0),
            triangleAt(first, 1), triangleAt(first, 2), first.end - first.begin > 3 ? ", ..." : ""),
        {}, Remedy::Mend);
  }
  if (inconsistent > 0) {
    return invalid(
        fmt::format("the mesh has an inconsistent orientation: triangles {} and {} have their "
                    "common {} in the same direction ({} such edges in all)",
                    triangleAt(*firstInconsistent, 0), triangleAt(*firstInconsistent, 1),
                    place(*firstInconsistent), inconsistent),
        {}, Remedy::Mend);
  }
  if (firstDoubled != nullptr) {
    return invalid(fmt::format("triangles {} and {} have the same corners, so they enclose nothing",
                               triangleAt(*firstDoubled, 0), triangleAt(*firstDoubled, 1)),
                   {}, Remedy::Mend);
  }
  return {};
}

/// Checks that the triangles around each vertex form one fan: they are connected across the edges
/// at the vertex.
Result<void> checkVertices(const TriangleMesh& mesh, const SurfaceEdges& edges) {
  UnionFind fans(3 * mesh.triangles.size());
  for (std::size_t i = 0; i < edges.sides.size(); i += 2) {
    uniteCorners(fans, mesh, edges.sides[i], edges.sides[i + 1]);
  }
  std::vector<std::uint32_t> fan(mesh.vertices.size(), kNoIndex);
  for (std::uint32_t corner = 0; corner < 3 * mesh.triangles.size(); ++corner) {
    const std::uint32_t vertex = mesh.triangles[corner / 3][corner % 3];
    const std::uint32_t found = fans.root(corner);
    if (fan[vertex] == kNoIndex) fan[vertex] = found;
    if (fan[vertex] != found) {
      return invalid(
          fmt::format("vertex {}, {}, is non-manifold: several fans of triangles touch there "
                      "(triangles {} and {} are in two of them)",
                      vertex, textOf(mesh.vertices[vertex]), fan[vertex] / 3, found / 3),
          {}, Remedy::Mend);
    }
  }
  return {};
}

}  // namespace

Result<void> checkClosedSurface(const TriangleMesh& mesh) {
  if (auto elements = checkElements(mesh); !elements) return elements;
  const SurfaceEdges edges = edgesOf(mesh.triangles);
  if (auto checked = checkEdges(mesh, edges); !checked) return checked;
  return checkVertices(mesh, edges);
}

}  // namespace t4d::model
