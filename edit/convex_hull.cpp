#include "edit/convex_hull.h"

#include <vector>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/convex_hull_3.h>

namespace t4d::edit {

Result<model::TriangleMesh> convexHull(std::span<const model::Point3> points) {
  using HullPoint = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
  std::vector<HullPoint> places;
  places.reserve(points.size());
  for (const model::Point3& p : points) places.emplace_back(p.x(), p.y(), p.z());
  CGAL::Surface_mesh<HullPoint> hull;
  CGAL::convex_hull_3(places.begin(), places.end(), hull);
  constexpr std::size_t kFewestFaces = 4;  // of a tetrahedron
  if (hull.number_of_faces() < kFewestFaces) {
    return invalid("encloses nothing: all its points are in a plane");
  }
  model::TriangleMesh mesh;
  mesh.vertices.reserve(hull.number_of_vertices());
  for (const auto vertex : hull.vertices()) {
    const HullPoint& p = hull.point(vertex);
    mesh.vertices.emplace_back(p.x(), p.y(), p.z());
  }
  for (const auto face : hull.faces()) {
    model::Triangle triangle{};
    std::size_t corner = 0;
    for (const auto vertex : hull.vertices_around_face(hull.halfedge(face))) {
      triangle.at(corner++) = static_cast<std::uint32_t>(vertex.idx());
    }
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

}  // namespace t4d::edit
