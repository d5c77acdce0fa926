#include "t4d/model/triangle_mesh.h"

#include <algorithm>

#include <Eigen/Geometry>

namespace t4d::model {

Bounds3 boundsOf(const TriangleMesh& mesh) {
  Bounds3 bounds;
  for (const Point3& vertex : mesh.vertices) bounds.add(vertex);
  return bounds;
}

double signedVolume(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return 0;
  const Bounds3 bounds = boundsOf(mesh);
  const Point3 middle = 0.5 * (bounds.min + bounds.max);
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Point3 p = mesh.vertices[a] - middle;
    sum += p.dot((mesh.vertices[b] - middle).cross(mesh.vertices[c] - middle));
  }
  return sum / 6;
}

double surfaceArea(const TriangleMesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Point3& p = mesh.vertices[a];
    sum += (mesh.vertices[b] - p).cross(mesh.vertices[c] - p).norm();
  }
  return sum / 2;
}

bool isClosed(const TriangleMesh& mesh) {
  // Each edge as (smaller vertex, larger vertex) in the high bits and its direction in the low one.
  std::vector<std::uint64_t> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const Triangle& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      const std::uint64_t from = triangle[i];
      const std::uint64_t to = triangle[(i + 1) % 3];
      edges.push_back(from < to ? from << 32 | to : (to << 32 | from) | std::uint64_t{1} << 63);
    }
  }
  constexpr std::uint64_t kDirection = std::uint64_t{1} << 63;
  std::sort(edges.begin(), edges.end(),
            [](std::uint64_t a, std::uint64_t b) { return (a & ~kDirection) < (b & ~kDirection); });
  for (std::size_t i = 0; i < edges.size();) {
    const std::uint64_t edge = edges[i] & ~kDirection;
    std::int64_t balance = 0;
    for (; i < edges.size() && (edges[i] & ~kDirection) == edge; ++i) {
      balance += (edges[i] & kDirection) != 0 ? -1 : 1;
    }
    if (balance != 0) return false;
  }
  return true;
}

}  // namespace t4d::model
