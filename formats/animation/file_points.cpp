#include "formats/animation/file_points.h"

#include <vector>

#include <fmt/format.h>

namespace t4d::formats {

Result<void> placeVertices(const FilePoints& file, std::span<const model::Point3> points,
                           std::span<model::Point3> vertices, const std::string& where) {
  // A fraction of the extent of all vertices: float32 coordinates and the arithmetic of other
  // programs round by less.
  constexpr double kTogether = 1e-5;
  model::Bounds3 bounds;
  std::vector<std::uint32_t> pointOf(vertices.size(), FilePoints::kUnused);
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const std::uint32_t vertex = file.vertexOf[i];
    if (vertex == FilePoints::kUnused) continue;
    bounds.add(points[i]);
    if (pointOf[vertex] != FilePoints::kUnused) continue;
    pointOf[vertex] = i;
    vertices[vertex] = points[i];
  }
  const double together = kTogether * (bounds.max - bounds.min).maxCoeff();
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const std::uint32_t vertex = file.vertexOf[i];
    if (vertex == FilePoints::kUnused) continue;
    const double apart = (points[i] - vertices[vertex]).norm();
    if (apart <= together) continue;
    return invalid(fmt::format("points {} and {} (counted from 0) are one vertex of the mesh, but "
                               "{:.3g} apart here: the surface would tear",
                               pointOf[vertex], i, apart),
                   where);
  }
  return {};
}

}  // namespace t4d::formats
