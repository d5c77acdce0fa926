#include "edit/surface_crossings.h"

#include <algorithm>
#include <array>
#include <exception>
#include <tuple>
#include <utility>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>
#include <fmt/format.h>

#include "model/parallel.h"

namespace t4d::edit {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using model::Triangle;

using Pair = std::pair<std::uint32_t, std::uint32_t>;

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

/// The box of a triangle, as CGAL's search takes it.
struct Box {
  using NT = double;
  using ID = std::size_t;

  std::array<double, 3> low;
  std::array<double, 3> high;
  std::uint32_t triangle;

  static constexpr int dimension() { return 3; }
  ID id() const { return triangle; }
  double min_coord(int axis) const { return low[axis]; }
  double max_coord(int axis) const { return high[axis]; }

  bool meets(const Box& other) const {
    for (int axis = 0; axis < 3; ++axis) {
      if (low[axis] > other.high[axis] || other.low[axis] > high[axis]) return false;
    }
    return true;
  }
  void add(const Box& other) {
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], other.low[axis]);
      high[axis] = std::max(high[axis], other.high[axis]);
    }
  }
};

/// Boxes in parts of a few thousand that are close to each other.
class Parts {
 public:
  explicit Parts(std::vector<Box> boxes) : boxes_(std::move(boxes)) { divide(0, boxes_.size()); }

  std::size_t size() const { return parts_.size(); }

  /// Calls visit(box, box) for all pairs of boxes that meet, one in this part and the other in it
  /// or in a later one.
  template <class Visit>
  void forEachPair(std::size_t number, const Visit& visit) const {
    const Part& part = parts_[number];
    std::vector<Box> own = within(part, part.bounds, part.bounds);
    CGAL::box_self_intersection_d(own.begin(), own.end(), visit);
    for (std::size_t other = number + 1; other < parts_.size(); ++other) {
      const Part& later = parts_[other];
      if (!part.bounds.meets(later.bounds)) continue;
      Box both = part.bounds;
      both.add(later.bounds);
      std::vector<Box> here = within(part, later.bounds, both);
      std::vector<Box> there = within(later, part.bounds, both);
      CGAL::box_intersection_d(here.begin(), here.end(), there.begin(), there.end(), visit);
    }
  }

 private:
  static constexpr std::size_t kBoxes = 20'000;

  struct Part {
    std::size_t begin, end;
    Box bounds;
  };

  void divide(std::size_t begin, std::size_t end) {
    if (begin == end) return;
    Box bounds = boxes_[begin];
    for (std::size_t i = begin; i < end; ++i) bounds.add(boxes_[i]);
    if (end - begin <= kBoxes) {
      parts_.push_back({begin, end, bounds});
      return;
    }
    const int axis = axesOf(bounds)[2];
    const auto at = [&](std::size_t i) { return boxes_.begin() + static_cast<std::ptrdiff_t>(i); };
    const std::size_t middle = begin + (end - begin) / 2;
    std::nth_element(at(begin), at(middle), at(end), [&](const Box& p, const Box& q) {
      return std::pair(p.low[axis] + p.high[axis], p.triangle) <
             std::pair(q.low[axis] + q.high[axis], q.triangle);
    });
    divide(begin, middle);
    divide(middle, end);
  }

  /// The shortest, ..., the longest.
  static std::array<int, 3> axesOf(const Box& bounds) {
    std::array<int, 3> axes = {0, 1, 2};
    std::ranges::stable_sort(axes, {},
                             [&](int axis) { return bounds.high[axis] - bounds.low[axis]; });
    return axes;
  }

  /// The boxes of a part that meet `place`. CGAL divides along its last axis first, and looks at
  /// all pairs where that divides nothing, as along the thickness of a sheet: its axes are those of
  /// `bounds`, the longest last.
  std::vector<Box> within(const Part& part, const Box& place, const Box& bounds) const {
    const std::array<int, 3> axes = axesOf(bounds);
    std::vector<Box> found;
    for (std::size_t i = part.begin; i < part.end; ++i) {
      const auto& [low, high, triangle] = boxes_[i];
      if (!boxes_[i].meets(place)) continue;
      found.push_back({{low[axes[0]], low[axes[1]], low[axes[2]]},
                       {high[axes[0]], high[axes[1]], high[axes[2]]},
                       triangle});
    }
    return found;
  }

  std::vector<Box> boxes_;
  std::vector<Part> parts_;
};

/// All pairs of triangles that meet, of a part with it and later ones, or `most` of them.
std::vector<Pair> pairsOf(const Parts& parts, std::size_t part, const PairTest& test,
                          std::size_t most) {
  std::vector<Pair> pairs;
  if (most == 0) return pairs;
  try {
    parts.forEachPair(part, [&](const Box& a, const Box& b) {
      const auto [low, high] = std::minmax({a.triangle, b.triangle});
      if (!test.meet(low, high)) return;
      pairs.emplace_back(low, high);
      if (pairs.size() == most) throw Enough();
    });
  } catch (const Enough&) {
    // These are as many as were asked for.
  }
  return pairs;
}

std::vector<Point> pointsOf(const model::TriangleMesh& mesh) {
  std::vector<Point> points;
  points.reserve(mesh.vertices.size());
  for (const model::Point3& p : mesh.vertices) points.emplace_back(p.x(), p.y(), p.z());
  return points;
}

Box boxOf(const model::TriangleMesh& mesh, std::uint32_t triangle) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  const auto& [p, q, r] = std::tie(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]);
  const model::Point3 low = p.cwiseMin(q).cwiseMin(r);
  const model::Point3 high = p.cwiseMax(q).cwiseMax(r);
  return {{low.x(), low.y(), low.z()}, {high.x(), high.y(), high.z()}, triangle};
}

Error searchFailed(const std::exception& error) {
  return fail(ErrorCode::Failed,
              fmt::format("the search for self-intersections failed: {}", error.what()));
}

}  // namespace

bool findsCrossings() { return true; }

Result<SurfaceCrossings> findCrossings(const model::TriangleMesh& mesh, std::size_t most) try {
  const std::vector<Point> points = pointsOf(mesh);
  SurfaceCrossings found;
  std::vector<Box> boxes;
  boxes.reserve(mesh.triangles.size());
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& [a, b, c] = mesh.triangles[i];
    if (CGAL::collinear(points[a], points[b], points[c])) {
      found.flat.push_back(i);
    } else {
      boxes.push_back(boxOf(mesh, i));
    }
  }
  const PairTest test(mesh, points);
  const Parts parts(std::move(boxes));
  // Batches are the same for any number of threads, and so is what is found.
  constexpr std::size_t kBatch = 64;
  for (std::size_t begin = 0; begin < parts.size() && found.pairs.size() <= most; begin += kBatch) {
    std::vector<std::vector<Pair>> pairs(std::min(kBatch, parts.size() - begin));
    model::forEach(pairs.size(), [&](std::size_t k) {
      pairs[k] = pairsOf(parts, begin + k, test, most + 1 - found.pairs.size());
    });
    for (const auto& some : pairs) found.pairs.insert(found.pairs.end(), some.begin(), some.end());
  }
  found.complete = found.pairs.size() <= most;
  if (!found.complete) found.pairs.resize(most);
  std::ranges::sort(found.pairs);
  return found;
} catch (const std::exception& error) {
  return searchFailed(error);
}

Result<SurfaceCrossings> findCrossingsOf(std::span<const std::uint32_t> triangles,
                                         const model::TriangleMesh& mesh) try {
  const std::vector<Point> points = pointsOf(mesh);
  const PairTest test(mesh, points);
  const auto isFlat = [&](std::uint32_t triangle) {
    const auto& [a, b, c] = mesh.triangles[triangle];
    return CGAL::collinear(points[a], points[b], points[c]);
  };
  SurfaceCrossings found;
  for (const std::uint32_t triangle : triangles) {
    if (isFlat(triangle)) {
      found.flat.push_back(triangle);
      continue;
    }
    const Box box = boxOf(mesh, triangle);
    for (std::uint32_t other = 0; other < mesh.triangles.size(); ++other) {
      if (other == triangle || !box.meets(boxOf(mesh, other))) continue;
      const auto pair = std::minmax(triangle, other);
      if (test.meet(pair.first, pair.second) && !isFlat(other)) found.pairs.emplace_back(pair);
    }
  }
  std::ranges::sort(found.pairs);
  const auto again = std::ranges::unique(found.pairs);
  found.pairs.erase(again.begin(), again.end());
  return found;
} catch (const std::exception& error) {
  return searchFailed(error);
}

Result<std::optional<mesh4d::StepCrossing>> crossingWithin(const model::TriangleMesh& mesh,
                                                           const model::Slab& step) {
  return mesh4d::crossingOf(mesh, step);
}

}  // namespace t4d::edit
