#include <algorithm>
#include <numeric>

#include <fmt/format.h>

#include "edit/mend_steps.h"
#include "model/union_find.h"
#include "t4d/mesh.h"

namespace t4d::edit {

using model::Point3;
using model::Triangle;
using model::TriangleMesh;

std::size_t weldVertices(TriangleMesh& mesh, double tolerance) {
  const auto count = static_cast<std::uint32_t>(mesh.vertices.size());
  const auto& places = mesh.vertices;
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::sort(order, [&](std::uint32_t a, std::uint32_t b) {
    if (tolerance > 0 && places[a].x() != places[b].x()) return places[a].x() < places[b].x();
    return std::lexicographical_compare(places[a].begin(), places[a].end(), places[b].begin(),
                                        places[b].end());
  });
  model::UnionFind sets(count);
  std::size_t merged = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    for (std::uint32_t j = i + 1; j < count; ++j) {
      const Point3 apart = (places[order[j]] - places[order[i]]).cwiseAbs();
      if (apart[0] > tolerance) break;
      if (apart.maxCoeff() <= tolerance) {
        merged += sets.unite(order[i], order[j]) ? 1 : 0;
      } else if (tolerance == 0) {
        break;  // equal vertices are next to each other
      }
    }
  }
  for (Triangle& triangle : mesh.triangles) {
    for (std::uint32_t& corner : triangle) corner = sets.root(corner);
  }
  return merged;
}

std::vector<std::uint32_t> dropUnusedVertices(TriangleMesh& mesh) {
  std::vector<std::uint32_t> number(mesh.vertices.size(), model::kNoIndex);
  for (const Triangle& triangle : mesh.triangles) {
    for (const std::uint32_t corner : triangle) number[corner] = 0;
  }
  std::vector<std::uint32_t> kept;
  for (std::uint32_t i = 0; i < number.size(); ++i) {
    if (number[i] == model::kNoIndex) continue;
    number[i] = static_cast<std::uint32_t>(kept.size());
    mesh.vertices[kept.size()] = mesh.vertices[i];
    kept.push_back(i);
  }
  mesh.vertices.resize(kept.size());
  for (Triangle& triangle : mesh.triangles) {
    for (std::uint32_t& corner : triangle) corner = number[corner];
  }
  return kept;
}

void weld(TriangleMesh& mesh, double tolerance, Changes& changes) {
  const std::size_t merged = weldVertices(mesh, tolerance);
  note(changes, SurfaceFault::Doubled, merged,
       tolerance > 0
           ? fmt::format("merged {} within {} of others", numberOf(merged, "vertex", "vertices"),
                         tolerance)
           : fmt::format("merged {} equal to others", numberOf(merged, "vertex", "vertices")));
}

}  // namespace t4d::edit
