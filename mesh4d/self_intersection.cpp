#include <algorithm>
#include <exception>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "mesh4d/cap.h"

namespace t4d::mesh4d {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;

constexpr std::size_t kNamed = 10;  // the number of triangles that an error names
/// The search stops here: surfaces can intersect themselves in as many pairs as they have
/// triangles, squared.
constexpr unsigned int kMaxPairs = 1000;

Result<void> checkAreas(const model::TriangleMesh& mesh,
                        const std::vector<Kernel::Point_3>& points) {
  std::vector<std::size_t> flat;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& [a, b, c] = mesh.triangles[i];
    if (CGAL::collinear(points[a], points[b], points[c])) flat.push_back(i);
  }
  if (flat.empty()) return {};
  const std::size_t count = flat.size();
  flat.resize(std::min(count, kNamed));
  return invalid(fmt::format("{} triangles have no area (counted from 0: {}{}), so TetGen cannot "
                             "fill the solid",
                             count, fmt::join(flat, ", "), count > kNamed ? ", ..." : ""),
                 {}, Remedy::ConeCaps);
}

}  // namespace

Result<void> checkNoSelfIntersection(const model::TriangleMesh& mesh) try {
  std::vector<Kernel::Point_3> points;
  points.reserve(mesh.vertices.size());
  for (const model::Point3& p : mesh.vertices) points.emplace_back(p.x(), p.y(), p.z());
  if (auto checked = checkAreas(mesh, points); !checked) return checked;

  SurfaceMesh surface;
  std::vector<SurfaceMesh::Vertex_index> vertices;
  vertices.reserve(points.size());
  for (const Kernel::Point_3& point : points) vertices.push_back(surface.add_vertex(point));
  for (const auto& [a, b, c] : mesh.triangles) {
    if (surface.add_face(vertices[a], vertices[b], vertices[c]) == SurfaceMesh::null_face()) {
      return invalid("the mesh is not a manifold");  // checkClosedSurface gives the location
    }
  }
  std::vector<std::pair<SurfaceMesh::Face_index, SurfaceMesh::Face_index>> pairs;
  CGAL::Polygon_mesh_processing::self_intersections(
      surface, std::back_inserter(pairs),
      CGAL::Polygon_mesh_processing::parameters::maximum_number(kMaxPairs));
  if (pairs.empty()) return {};
  std::vector<std::string> names;
  for (auto [first, second] : pairs) {
    if (second < first) std::swap(first, second);
    names.push_back(fmt::format("{} with {}", first.idx(), second.idx()));
  }
  std::sort(names.begin(), names.end());
  names.resize(std::min(names.size(), kNamed));
  return invalid(fmt::format("the mesh intersects itself: {}{} pairs of triangles do (counted from "
                             "0: {}{}), so TetGen cannot fill the solid",
                             pairs.size() < kMaxPairs ? "" : "at least ", pairs.size(),
                             fmt::join(names, ", "), pairs.size() > kNamed ? ", ..." : ""),
                 {}, Remedy::ConeCaps);
} catch (const std::exception& error) {
  return fail(ErrorCode::Failed,
              fmt::format("the search for self-intersections failed: {}", error.what()));
}

}  // namespace t4d::mesh4d
