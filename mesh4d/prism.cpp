#include "mesh4d/prism.h"

#include <algorithm>
#include <array>

#include "model/corner_attributes.h"
#include "model/surface_edges.h"

namespace t4d::mesh4d {
namespace {

using model::Cell;
using model::Connectivity;
using model::Triangle;

/// The edges of a closed mesh, numbered in the order in which triangles first use them.
struct Edges {
  std::vector<std::array<std::uint32_t, 2>> ends;
  std::vector<std::array<std::uint32_t, 3>> ofTriangle;  // side i is corner i to corner i + 1
};

Edges numberedEdges(const model::TriangleMesh& mesh) {
  // The first side of an edge represents it, so edges are numbered in the order of sides.
  const model::SurfaceEdges found = model::edgesOf(mesh.triangles);
  std::vector<std::uint32_t> firstSide(found.sides.size());
  for (const model::EdgeSides& edge : found.edges) {
    for (std::uint32_t i = edge.begin; i < edge.end; ++i) {
      firstSide[found.sides[i]] = found.sides[edge.begin];
    }
  }
  Edges edges;
  edges.ofTriangle.resize(mesh.triangles.size());
  for (std::uint32_t side = 0; side < firstSide.size(); ++side) {
    std::uint32_t& edge = edges.ofTriangle[side / 3][side % 3];
    if (firstSide[side] == side) {
      edge = static_cast<std::uint32_t>(edges.ends.size());
      edges.ends.push_back({model::fromOf(mesh, side), model::toOf(mesh, side)});
    } else {
      edge = edges.ofTriangle[firstSide[side] / 3][firstSide[side] % 3];
    }
  }
  return edges;
}

Connectivity fourteenCells(const model::TriangleMesh& mesh) {
  const Edges edges = numberedEdges(mesh);
  const auto vertexCount = static_cast<std::uint32_t>(mesh.vertices.size());
  const auto edgeCount = static_cast<std::uint32_t>(edges.ends.size());
  const auto triangleCount = static_cast<std::uint32_t>(mesh.triangles.size());
  Connectivity step;
  step.lowerCount = vertexCount;
  step.upperCount = vertexCount;
  step.vertexCount = 2 * vertexCount + edgeCount + triangleCount;
  const std::uint32_t firstQuad = vertexCount;
  const std::uint32_t firstPrism = firstQuad + edgeCount;
  const std::uint32_t up = firstPrism + triangleCount;  // from a lower vertex to its upper copy

  step.means.offsets.reserve(edgeCount + triangleCount + 1);
  step.means.sources.reserve(4 * edgeCount + 6 * triangleCount);
  for (const auto& [from, to] : edges.ends) {
    step.means.add(std::array{from, to, up + from, up + to});
  }
  for (const auto& [a, b, c] : mesh.triangles) {
    step.means.add(std::array{a, b, c, up + a, up + b, up + c});
  }

  step.cells.reserve(14 * std::size_t{triangleCount});
  for (std::uint32_t i = 0; i < triangleCount; ++i) {
    const Triangle& a = mesh.triangles[i];
    const std::uint32_t g = firstPrism + i;
    step.cells.push_back({a[0], a[1], a[2], g});
    step.cells.push_back({up + a[0], up + a[2], up + a[1], g});
    for (int side = 0; side < 3; ++side) {
      const std::uint32_t from = a[side];
      const std::uint32_t to = a[(side + 1) % 3];
      const std::uint32_t q = firstQuad + edges.ofTriangle[i][side];
      step.cells.push_back({to, from, q, g});
      step.cells.push_back({from, up + from, q, g});
      step.cells.push_back({up + from, up + to, q, g});
      step.cells.push_back({up + to, to, q, g});
    }
  }
  return step;
}

/// The staircase from the triangle's smallest vertex to its largest: every quadrilateral is split
/// by the diagonal that rises from its smaller vertex, so neighbours agree.
Connectivity threeCells(const model::TriangleMesh& mesh) {
  const auto vertexCount = static_cast<std::uint32_t>(mesh.vertices.size());
  Connectivity step;
  step.lowerCount = vertexCount;
  step.upperCount = vertexCount;
  step.vertexCount = 2 * vertexCount;
  const std::uint32_t up = vertexCount;
  step.cells.reserve(3 * mesh.triangles.size());
  for (Triangle a : mesh.triangles) {
    bool even = true;
    const auto order = [&](int i, int j) {
      if (a[i] > a[j]) {
        std::swap(a[i], a[j]);
        even = !even;
      }
    };
    order(0, 1);
    order(1, 2);
    order(0, 1);
    const Cell cells[3] = {{a[0], a[1], a[2], up + a[2]},
                           {a[0], a[1], up + a[2], up + a[1]},
                           {a[0], up + a[1], up + a[2], up + a[0]}};
    for (Cell cell : cells) {
      if (!even) std::swap(cell[0], cell[1]);
      step.cells.push_back(cell);
    }
  }
  return step;
}

}  // namespace

std::vector<model::Attribute> cellAttributes(const std::vector<std::uint32_t>& triangles,
                                             const std::vector<std::uint8_t>& kinds) {
  return {model::makeAttribute("triangle", model::Domain::Cell, triangles),
          model::makeAttribute("kind", model::Domain::Cell, kinds)};
}

std::vector<model::Attribute> inputAttributes(const model::TriangleMesh& mesh,
                                              const std::vector<std::uint32_t>& triangles) {
  std::vector<model::Attribute> made;
  for (const model::Attribute& given : mesh.attributes) {
    // A mesh that is a slice itself has these.
    if (given.name == "triangle" || given.name == "kind") continue;
    const bool ofVertices = given.domain == model::Domain::Vertex;
    model::Attribute rows{given.name, model::Domain::Cell, given.type, given.components, {}};
    if (ofVertices) {
      rows.name += model::kCornersOf;
      rows.components *= 3;
    }
    const std::size_t bytes = given.rowBytes();
    rows.values.reserve(rows.rowBytes() * triangles.size());
    const auto put = [&](std::uint32_t row) {
      rows.values.insert(rows.values.end(), given.row(row), given.row(row) + bytes);
    };
    for (const std::uint32_t triangle : triangles) {
      if (triangle == kNoTriangle) {
        rows.values.resize(rows.values.size() + rows.rowBytes());
      } else if (ofVertices) {
        for (const std::uint32_t corner : mesh.triangles[triangle]) put(corner);
      } else {
        put(triangle);
      }
    }
    made.push_back(std::move(rows));
  }
  return made;
}

std::shared_ptr<const Connectivity> stepConnectivity(const model::TriangleMesh& mesh,
                                                     PrismSplit split) {
  auto step = std::make_shared<Connectivity>(split == PrismSplit::Fourteen ? fourteenCells(mesh)
                                                                           : threeCells(mesh));
  const std::size_t perTriangle = step->cells.size() / mesh.triangles.size();
  std::vector<std::uint32_t> triangles(step->cells.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    triangles[i] = static_cast<std::uint32_t>(i / perTriangle);
  }
  step->cellAttributes = cellAttributes(
      triangles,
      std::vector<std::uint8_t>(step->cells.size(), static_cast<std::uint8_t>(CellKind::Side)));
  for (model::Attribute& attribute : inputAttributes(mesh, triangles)) {
    step->cellAttributes.push_back(std::move(attribute));
  }
  return step;
}

}  // namespace t4d::mesh4d
