#include "t4d/measure/surface_genus.h"

#include <algorithm>
#include <functional>

#include "t4d/model/union_find.h"

namespace t4d::measure {

std::vector<ConnectedSurface> surfacesOf(const model::TriangleMesh& mesh) {
  model::UnionFind surfaces(mesh.vertices.size());
  std::vector<char> used(mesh.vertices.size(), 0);
  std::vector<std::uint64_t> edges;  // the smaller vertex in the upper half
  edges.reserve(3 * mesh.triangles.size());
  for (const model::Triangle& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t a = triangle[i];
      const std::uint32_t b = triangle[(i + 1) % 3];
      used[a] = 1;
      surfaces.unite(a, b);
      edges.push_back(std::uint64_t{std::min(a, b)} << 32 | std::max(a, b));
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());

  std::vector<std::int64_t> euler(mesh.vertices.size(), 0);  // at the root of each surface
  for (std::uint32_t v = 0; v < used.size(); ++v) euler[surfaces.root(v)] += used[v];
  for (const std::uint64_t edge : edges) {
    --euler[surfaces.root(static_cast<std::uint32_t>(edge >> 32))];
  }
  for (const model::Triangle& triangle : mesh.triangles) ++euler[surfaces.root(triangle[0])];

  // The volume of each about its first vertex, which is its root.
  std::vector<double> volumes(mesh.vertices.size(), 0);
  for (const auto& [i, j, k] : mesh.triangles) {
    const std::uint32_t root = surfaces.root(i);
    const model::Point3& about = mesh.vertices[root];
    const model::Point3 a = mesh.vertices[i] - about;
    const model::Point3 b = mesh.vertices[j] - about;
    volumes[root] += a.dot(b.cross(mesh.vertices[k] - about)) / 6;
  }

  std::vector<ConnectedSurface> found;
  for (std::uint32_t v = 0; v < used.size(); ++v) {
    if (used[v] == 0 || surfaces.root(v) != v) continue;
    found.push_back({1 - 0.5 * static_cast<double>(euler[v]), volumes[v]});
  }
  return found;
}

std::vector<double> generaOf(const model::TriangleMesh& mesh) {
  std::vector<double> genera;
  for (const ConnectedSurface& surface : surfacesOf(mesh)) genera.push_back(surface.genus);
  std::ranges::sort(genera, std::greater());
  return genera;
}

}  // namespace t4d::measure
