#include "t4d/model/surface_check.h"

#include <algorithm>

#include <fmt/format.h>

#include "t4d/model/union_find.h"

namespace t4d::model {
namespace {

std::string textOf(const Point3& point) {
  return fmt::format("({}, {}, {})", point.x(), point.y(), point.z());
}

/// One side of a triangle, from its vertex `corner` to the next.
struct HalfEdge {
  std::uint32_t low;
  std::uint32_t high;
  std::uint32_t triangle;
  bool forward;  // the triangle traverses it from low to high
};

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

std::vector<HalfEdge> sortedHalfEdges(const TriangleMesh& mesh) {
  std::vector<HalfEdge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    for (int side = 0; side < 3; ++side) {
      const std::uint32_t from = mesh.triangles[i][side];
      const std::uint32_t to = mesh.triangles[i][(side + 1) % 3];
      edges.push_back({std::min(from, to), std::max(from, to), i, from < to});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  return edges;
}

/// Checks that each edge has exactly two triangles, which traverse it in opposite directions.
Result<void> checkEdges(const TriangleMesh& mesh, const std::vector<HalfEdge>& edges) {
  std::size_t open = 0;
  std::size_t nonManifold = 0;
  std::size_t inconsistent = 0;
  const HalfEdge* firstOpen = nullptr;
  const HalfEdge* firstNonManifold = nullptr;
  const HalfEdge* firstInconsistent = nullptr;
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i + 1;
    while (end < edges.size() && edges[end].low == edges[i].low &&
           edges[end].high == edges[i].high) {
      ++end;
    }
    const auto note = [&](std::size_t& count, const HalfEdge*& first) {
      ++count;
      if (first == nullptr) first = &edges[i];
    };
    if (end - i == 1) {
      note(open, firstOpen);
    } else if (end - i > 2) {
      note(nonManifold, firstNonManifold);
    } else if (edges[i].forward == edges[i + 1].forward) {
      note(inconsistent, firstInconsistent);
    }
    i = end;
  }
  const auto place = [&](const HalfEdge& edge) {
    return fmt::format("edge {}-{} at {} to {}", edge.low, edge.high,
                       textOf(mesh.vertices[edge.low]), textOf(mesh.vertices[edge.high]));
  };
  if (open > 0) {
    return invalid(
        fmt::format("the mesh is open: {} boundary edges, the first of triangle {}, {}; a "
                    "solid needs a closed surface",
                    open, firstOpen->triangle, place(*firstOpen)),
        {}, Remedy::Mend);
  }
  if (nonManifold > 0) {
    return invalid(
        fmt::format(
            "the mesh has {} non-manifold edge{}, with more than two triangles; the first is "
            "{} (triangles {}, {}, {}{})",
            nonManifold, nonManifold == 1 ? "" : "s", place(*firstNonManifold),
            firstNonManifold[0].triangle, firstNonManifold[1].triangle,
            firstNonManifold[2].triangle,
            firstNonManifold + 3 < edges.data() + edges.size() &&
                    firstNonManifold[3].low == firstNonManifold->low &&
                    firstNonManifold[3].high == firstNonManifold->high
                ? ", ..."
                : ""),
        {}, Remedy::Mend);
  }
  if (inconsistent > 0) {
    return invalid(
        fmt::format("the mesh has an inconsistent orientation: triangles {} and {} have their "
                    "common {} in the same direction ({} such edges in all)",
                    firstInconsistent[0].triangle, firstInconsistent[1].triangle,
                    place(*firstInconsistent), inconsistent),
        {}, Remedy::Mend);
  }
  return {};
}

/// Checks that the triangles around each vertex form one fan: they are connected across the edges
/// at the vertex.
Result<void> checkVertices(const TriangleMesh& mesh, const std::vector<HalfEdge>& edges) {
  // Corners (3 * triangle + corner), united across each edge at both of its ends.
  UnionFind fans(3 * mesh.triangles.size());
  const auto cornerAt = [&](std::uint32_t triangle, std::uint32_t vertex) {
    const Triangle& corners = mesh.triangles[triangle];
    const auto corner = std::find(corners.begin(), corners.end(), vertex) - corners.begin();
    return static_cast<std::uint32_t>(3 * triangle + corner);
  };
  for (std::size_t i = 0; i + 1 < edges.size(); i += 2) {
    for (const std::uint32_t vertex : {edges[i].low, edges[i].high}) {
      fans.unite(cornerAt(edges[i].triangle, vertex), cornerAt(edges[i + 1].triangle, vertex));
    }
  }
  constexpr std::uint32_t kNone = ~0U;
  std::vector<std::uint32_t> fan(mesh.vertices.size(), kNone);
  for (std::uint32_t corner = 0; corner < 3 * mesh.triangles.size(); ++corner) {
    const std::uint32_t vertex = mesh.triangles[corner / 3][corner % 3];
    const std::uint32_t found = fans.root(corner);
    if (fan[vertex] == kNone) fan[vertex] = found;
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
  const std::vector<HalfEdge> edges = sortedHalfEdges(mesh);
  if (auto checked = checkEdges(mesh, edges); !checked) return checked;
  return checkVertices(mesh, edges);
}

}  // namespace t4d::model
