#include "t4d/edit/surface_crossings.h"

#include <algorithm>
#include <array>
#include <exception>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>
#include <fmt/format.h>

namespace t4d::edit {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, std::uint32_t>;
using model::Triangle;

struct Enough {};

class PairTest {
 public:
  PairTest(const model::TriangleMesh& mesh, const std::vector<Point>& points)
      : mesh_(mesh), points_(points) {}

  bool meet(std::uint32_t first, std::uint32_t second) const {
    Triangle a = mesh_.triangles[first];
    Triangle b = mesh_.triangles[second];
    // Shared vertices to the front.
    std::size_t shared = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto found = std::find(b.begin() + shared, b.end(), a[i]);
      if (found == b.end()) continue;
      std::swap(a[i], a[shared]);
      std::swap(*found, b[shared]);
      ++shared;
    }
    if (shared == 3) return true;
    if (shared == 2) {
      const auto& [p, q, r] = std::tie(points_[a[0]], points_[a[1]], points_[a[2]]);
      const Point& s = points_[b[2]];
      return CGAL::coplanar(p, q, r, s) && CGAL::coplanar_orientation(p, q, r, s) == CGAL::POSITIVE;
    }
    if (shared == 1) {
      return CGAL::do_intersect(triangle(a), Kernel::Segment_3(points_[b[1]], points_[b[2]])) ||
             CGAL::do_intersect(triangle(b), Kernel::Segment_3(points_[a[1]], points_[a[2]]));
    }
    return CGAL::do_intersect(triangle(a), triangle(b));
  }

 private:
  Kernel::Triangle_3 triangle(const Triangle& corners) const {
    return {points_[corners[0]], points_[corners[1]], points_[corners[2]]};
  }

  const model::TriangleMesh& mesh_;
  const std::vector<Point>& points_;
};

}  // namespace

bool findsCrossings() { return true; }

Result<SurfaceCrossings> findCrossings(const model::TriangleMesh& mesh, std::size_t most) try {
  std::vector<Point> points;
  points.reserve(mesh.vertices.size());
  for (const model::Point3& p : mesh.vertices) points.emplace_back(p.x(), p.y(), p.z());
  SurfaceCrossings found;
  std::vector<Box> boxes;
  boxes.reserve(mesh.triangles.size());
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& [a, b, c] = mesh.triangles[i];
    if (CGAL::collinear(points[a], points[b], points[c])) {
      found.flat.push_back(i);
    } else {
      boxes.emplace_back(points[a].bbox() + points[b].bbox() + points[c].bbox(), i);
    }
  }
  const PairTest test(mesh, points);
  try {
    CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), [&](const Box& a, const Box& b) {
      const auto [low, high] = std::minmax({a.info(), b.info()});
      if (!test.meet(low, high)) return;
      if (found.pairs.size() == most) {
        found.complete = false;
        throw Enough();
      }
      found.pairs.emplace_back(low, high);
    });
  } catch (const Enough&) {
    // As many as were asked for.
  }
  std::ranges::sort(found.pairs);
  return found;
} catch (const std::exception& error) {
  return fail(ErrorCode::Failed,
              fmt::format("the search for self-intersections failed: {}", error.what()));
}

Result<std::optional<mesh4d::StepCrossing>> crossingWithin(const model::TriangleMesh& mesh,
                                                           const model::Slab& step) {
  return mesh4d::crossingOf(mesh, step);
}

}  // namespace t4d::edit
