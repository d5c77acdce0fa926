#include "t4d/edit/surface_crossings.h"

#include <algorithm>
#include <array>
#include <exception>
#include <utility>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>
#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

namespace t4d::edit {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, std::uint32_t>;
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

/// Boxes in order of their lower ends along the longest axis, in parts of equal numbers, and for
/// each part those before it that reach it: each pair that meets is in one part, or between it and
/// these.
class Parts {
 public:
  explicit Parts(std::vector<Box> boxes) : boxes_(std::move(boxes)) {
    if (boxes_.empty()) return;
    CGAL::Bbox_3 all;
    for (const Box& box : boxes_) all += box.bbox();
    std::array<int, 3> axes = {0, 1, 2};
    std::ranges::stable_sort(axes, {}, [&](int axis) { return all.min(axis) - all.max(axis); });
    // CGAL divides along its last axis first, and looks at all pairs where that divides nothing:
    // along the thickness of a sheet, or across a part. Its first axis is the shortest one.
    const std::array<int, 3> order = {axes[2], axes[0], axes[1]};
    constexpr int kLongest = 1;
    for (Box& box : boxes_) {
      std::array<double, 3> low{};
      std::array<double, 3> high{};
      for (int k = 0; k < 3; ++k) {
        low[k] = box.min_coord(order[k]);
        high[k] = box.max_coord(order[k]);
      }
      box = Box(low.data(), high.data(), box.info());
    }
    tbb::parallel_sort(boxes_.begin(), boxes_.end(), [](const Box& p, const Box& q) {
      return std::pair(p.min_coord(kLongest), p.info()) <
             std::pair(q.min_coord(kLongest), q.info());
    });
    reaching_.resize((boxes_.size() + kBoxes - 1) / kBoxes);
    for (std::size_t i = 0; i < boxes_.size(); ++i) {
      for (std::size_t part = i / kBoxes + 1; part < reaching_.size(); ++part) {
        if (boxes_[i].max_coord(kLongest) < boxes_[part * kBoxes].min_coord(kLongest)) break;
        reaching_[part].push_back(boxes_[i]);
      }
    }
  }

  std::size_t size() const { return reaching_.size(); }

  /// Calls visit(box, box) for all pairs of a part.
  template <class Visit>
  void forEachPair(std::size_t part, const Visit& visit) {
    const auto begin = boxes_.begin() + static_cast<std::ptrdiff_t>(part * kBoxes);
    const auto end =
        boxes_.begin() + static_cast<std::ptrdiff_t>(std::min((part + 1) * kBoxes, boxes_.size()));
    std::vector<Box>& before = reaching_[part];
    CGAL::box_intersection_d(before.begin(), before.end(), begin, end, visit);
    CGAL::box_self_intersection_d(begin, end, visit);
  }

 private:
  static constexpr std::size_t kBoxes = 20'000;

  std::vector<Box> boxes_;
  std::vector<std::vector<Box>> reaching_;
};

/// All pairs of a part that meet, or `most` of them.
std::vector<Pair> pairsOf(Parts& parts, std::size_t part, const PairTest& test, std::size_t most) {
  std::vector<Pair> pairs;
  if (most == 0) return pairs;
  try {
    parts.forEachPair(part, [&](const Box& a, const Box& b) {
      const auto [low, high] = std::minmax({a.info(), b.info()});
      if (!test.meet(low, high)) return;
      pairs.emplace_back(low, high);
      if (pairs.size() == most) throw Enough();
    });
  } catch (const Enough&) {
    // As many as were asked for.
  }
  return pairs;
}

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
  Parts parts(std::move(boxes));
  // Batches are the same for any number of threads, and so is what is found.
  constexpr std::size_t kBatch = 64;
  for (std::size_t begin = 0; begin < parts.size() && found.pairs.size() <= most; begin += kBatch) {
    std::vector<std::vector<Pair>> pairs(std::min(kBatch, parts.size() - begin));
    tbb::parallel_for(std::size_t{0}, pairs.size(), [&](std::size_t k) {
      pairs[k] = pairsOf(parts, begin + k, test, most + 1 - found.pairs.size());
    });
    for (const auto& some : pairs) found.pairs.insert(found.pairs.end(), some.begin(), some.end());
  }
  found.complete = found.pairs.size() <= most;
  if (!found.complete) found.pairs.resize(most);
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
