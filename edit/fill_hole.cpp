#include "edit/fill_hole.h"

#include <exception>
#include <iterator>
#include <limits>
#include <utility>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/utility.h>
#include <fmt/format.h>

namespace t4d::edit {
namespace {

using HoleKernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using HoleTriangle = CGAL::Triple<int, int, int>;

/// Numbers in the loop; empty if there is no way.
std::vector<HoleTriangle> throughDelaunay(const model::TriangleMesh& mesh,
                                          std::span<const std::uint32_t> loop,
                                          std::span<const std::uint32_t> apexes) {
  const auto placesOf = [&](std::span<const std::uint32_t> vertices) {
    std::vector<HoleKernel::Point_3> points;
    points.reserve(vertices.size());
    for (const std::uint32_t vertex : vertices) {
      const model::Point3& p = mesh.vertices[vertex];
      points.emplace_back(p.x(), p.y(), p.z());
    }
    return points;
  };
  std::vector<HoleTriangle> found;
  namespace parameters = CGAL::parameters;
  CGAL::Polygon_mesh_processing::triangulate_hole_polyline(
      placesOf(loop), placesOf(apexes), std::back_inserter(found),
      parameters::use_delaunay_triangulation(true).do_not_use_cubic_algorithm(true));
  return found;
}

/// Least area, by dynamic programming over the parts i .. k of the loop.
std::vector<HoleTriangle> ofLeastArea(const model::TriangleMesh& mesh,
                                      std::span<const std::uint32_t> loop) {
  const int count = static_cast<int>(loop.size());
  const auto at = [&](int i) -> const model::Point3& { return mesh.vertices[loop[i]]; };
  std::vector<double> least(loop.size() * loop.size(), 0);
  std::vector<int> middle(loop.size() * loop.size(), -1);
  const auto of = [&](int i, int k) {
    return static_cast<std::size_t>(i) * loop.size() + static_cast<std::size_t>(k);
  };
  for (int length = 2; length < count; ++length) {
    for (int i = 0; i + length < count; ++i) {
      const int k = i + length;
      double best = std::numeric_limits<double>::infinity();
      for (int j = i + 1; j < k; ++j) {
        const double area = (at(j) - at(i)).cross(at(k) - at(i)).norm() / 2;
        const double sum = least[of(i, j)] + least[of(j, k)] + area;
        if (sum < best) {
          best = sum;
          middle[of(i, k)] = j;
        }
      }
      least[of(i, k)] = best;
    }
  }
  std::vector<HoleTriangle> result;
  std::vector<std::pair<int, int>> parts = {{0, count - 1}};
  while (!parts.empty()) {
    const auto [i, k] = parts.back();
    parts.pop_back();
    if (k - i < 2) continue;
    const int j = middle[of(i, k)];
    if (j < 0) return {};  // coordinates too large
    result.emplace_back(i, j, k);
    parts.emplace_back(i, j);
    parts.emplace_back(j, k);
  }
  return result;
}

}  // namespace

Result<std::vector<model::Triangle>> fillHole(const model::TriangleMesh& mesh,
                                              std::span<const std::uint32_t> loop,
                                              std::span<const std::uint32_t> apexes) try {
  std::vector<HoleTriangle> found;
  if (loop.size() > 3) found = throughDelaunay(mesh, loop, apexes);
  if (found.size() + 2 != loop.size()) {
    found = loop.size() <= kMostSides ? ofLeastArea(mesh, loop) : std::vector<HoleTriangle>{};
  }
  if (found.size() + 2 != loop.size()) {
    return fail(ErrorCode::Unsupported,
                fmt::format("no triangles close its hole of {} sides", loop.size()), {},
                Remedy::Remesh);
  }
  std::vector<model::Triangle> triangles;
  triangles.reserve(found.size());
  for (const HoleTriangle& triangle : found) {
    // Ascending order is the direction of the loop. The triangle is turned against it.
    std::array<int, 3> at = {triangle.first, triangle.second, triangle.third};
    std::ranges::sort(at);
    triangles.push_back({loop[at[2]], loop[at[1]], loop[at[0]]});
  }
  return triangles;
} catch (const std::exception& error) {
  return fail(ErrorCode::Failed, fmt::format("filling a hole failed: {}", error.what()));
}

}  // namespace t4d::edit
