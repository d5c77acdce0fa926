#include "measure/surface_genus.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <numeric>

#include "measure/components.h"
#include "model/surface_components.h"

namespace t4d::measure {

namespace {

/// For each vertex, the number of edges to vertices with larger numbers.
std::vector<std::uint32_t> edgesUp(const model::TriangleMesh& mesh) {
  const auto forEdges = [&](auto work) {
    for (const auto& [a, b, c] : mesh.triangles) {
      work(std::min(a, b), std::max(a, b));
      work(std::min(b, c), std::max(b, c));
      work(std::min(a, c), std::max(a, c));
    }
  };
  // The other ends of each vertex's edges, once for every triangle: those of v end before ends[v].
  std::vector<std::size_t> ends(mesh.vertices.size() + 1, 0);
  forEdges([&](std::uint32_t low, std::uint32_t) { ++ends[low + 1]; });
  std::partial_sum(ends.begin(), ends.end(), ends.begin());
  std::vector<std::uint32_t> others(ends.back());
  forEdges([&](std::uint32_t low, std::uint32_t high) { others[ends[low]++] = high; });

  std::vector<std::uint32_t> counts(mesh.vertices.size(), 0);
  std::vector<std::uint32_t> seenFrom(mesh.vertices.size(), 0);  // the last vertex, plus 1
  std::size_t at = 0;
  for (std::uint32_t low = 0; low < counts.size(); ++low) {
    for (; at < ends[low]; ++at) {
      std::uint32_t& seen = seenFrom[others[at]];
      counts[low] += static_cast<std::uint32_t>(seen != low + 1);
      seen = low + 1;
    }
  }
  return counts;
}

}  // namespace

std::vector<ConnectedSurface> surfacesOf(const model::TriangleMesh& mesh) {
  model::UnionFind surfaces = componentsOf(mesh);
  std::vector<char> used(mesh.vertices.size(), 0);
  for (const auto& [a, b, c] : mesh.triangles) used[a] = used[b] = used[c] = 1;

  const std::vector<std::uint32_t> edges = edgesUp(mesh);
  std::vector<std::int64_t> euler(mesh.vertices.size(), 0);  // at the root of each surface
  for (std::uint32_t v = 0; v < used.size(); ++v) {
    euler[surfaces.root(v)] += used[v] - std::int64_t{edges[v]};
  }
  // The volume of each about its first vertex, which is its root.
  std::vector<double> volumes(mesh.vertices.size(), 0);
  for (const auto& [i, j, k] : mesh.triangles) {
    const std::uint32_t root = surfaces.root(i);
    const model::Point3& about = mesh.vertices[root];
    const model::Point3 a = mesh.vertices[i] - about;
    const model::Point3 b = mesh.vertices[j] - about;
    volumes[root] += a.dot(b.cross(mesh.vertices[k] - about)) / 6;
    ++euler[root];
  }

  std::vector<ConnectedSurface> found;
  for (std::uint32_t v = 0; v < used.size(); ++v) {
    if (used[v] == 0 || surfaces.root(v) != v) continue;
    found.push_back({1 - 0.5 * static_cast<double>(euler[v]), volumes[v], v});
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
