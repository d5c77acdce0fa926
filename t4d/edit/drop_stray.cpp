#include <algorithm>
#include <tuple>

#include <fmt/format.h>

#include "t4d/edit/mend_steps.h"
#include "t4d/model/surface_edges.h"
#include "t4d/model/union_find.h"

namespace t4d::edit {
namespace {

using model::Triangle;
using model::TriangleMesh;

/// Drops parts between edges with an odd number of triangles. Returns how many triangles.
std::size_t dropStrayOnce(TriangleMesh& mesh) {
  const model::SurfaceEdges edges = model::edgesOf(mesh.triangles);
  const auto countOf = [](const model::EdgeSides& edge) { return edge.end - edge.begin; };
  const auto isOdd = [&](const model::EdgeSides& edge) { return countOf(edge) % 2 != 0; };
  if (std::ranges::none_of(edges.edges,
                           [&](const auto& edge) { return isOdd(edge) && countOf(edge) > 2; })) {
    return 0;
  }
  model::UnionFind parts(mesh.triangles.size());
  for (const model::EdgeSides& edge : edges.edges) {
    if (countOf(edge) != 2) continue;
    parts.unite(edges.sides[edge.begin] / 3, edges.sides[edge.begin + 1] / 3);
  }
  struct Part {
    std::uint32_t root = 0;
    double area = 0;
    bool touches = false;  // an edge of three or more
    bool fits = true;      // all that it ends at has an odd number
    std::vector<std::uint32_t> ends;
  };
  std::vector<Part> all(mesh.triangles.size());
  double whole = 0;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    Part& part = all[parts.root(i)];
    part.root = parts.root(i);
    part.area += areaOf(mesh, i);
    whole += areaOf(mesh, i);
  }
  std::vector<std::uint32_t> roots;
  for (std::uint32_t e = 0; e < edges.edges.size(); ++e) {
    const model::EdgeSides& edge = edges.edges[e];
    if (countOf(edge) == 2) continue;
    roots.clear();
    for (std::uint32_t i = edge.begin; i < edge.end; ++i) {
      roots.push_back(parts.root(edges.sides[i] / 3));
    }
    std::ranges::sort(roots);
    for (auto at = roots.begin(); at != roots.end();) {
      const auto end = std::upper_bound(at, roots.end(), *at);
      if ((end - at) % 2 != 0) {
        Part& part = all[*at];
        part.touches |= countOf(edge) > 2;
        part.fits &= isOdd(edge);
        part.ends.push_back(e);
      }
      at = end;
    }
  }
  std::erase_if(
      all, [&](const Part& part) { return !part.touches || !part.fits || part.area > whole / 2; });
  std::ranges::sort(all, [](const Part& a, const Part& b) {
    return std::tie(a.area, a.root) < std::tie(b.area, b.root);
  });
  // Of parts that end at the same edge, only the smallest at a time.
  std::vector<bool> taken(edges.edges.size());
  std::vector<bool> stray(mesh.triangles.size());
  for (const Part& part : all) {
    if (std::ranges::any_of(part.ends, [&](std::uint32_t edge) { return taken[edge]; })) continue;
    for (const std::uint32_t edge : part.ends) taken[edge] = true;
    stray[part.root] = true;
  }
  std::uint32_t at = 0;
  return std::erase_if(mesh.triangles, [&](const Triangle&) { return stray[parts.root(at++)]; });
}

}  // namespace

void dropStray(TriangleMesh& mesh, Changes& changes) {
  std::size_t dropped = 0;
  while (const std::size_t now = dropStrayOnce(mesh)) dropped += now;
  note(changes, SurfaceFault::Stray, dropped,
       fmt::format("dropped {} of parts that hang at an edge or divide the inside",
                   numberOf(dropped, "triangle", "triangles")));
}

}  // namespace t4d::edit
