#include "voxel4d/union_surface.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>

#include "model/box_tree.h"
#include "model/parallel.h"
#include "model/surface_edges.h"
#include "voxel4d/convex_pieces.h"
#include "voxel4d/fixed_point.h"

namespace t4d::voxel4d {
namespace {

using model::Bounds3;
using model::Point3;
using model::Triangle;

/// Segments along which triangles cross, in all. Solids that overlap have a few for each triangle
/// where they cross; heaps of needles that all cross each other have more, and would take minutes.
constexpr std::uint64_t kMostCuts = 500'000;

/// Zero for a triangle that is narrower than the tolerance.
Point3 normalOf(const std::array<Point3, 3>& t, double tolerance) {
  const Point3 normal = (t[1] - t[0]).cross(t[2] - t[0]);
  const double longest =
      std::max({(t[1] - t[0]).norm(), (t[2] - t[1]).norm(), (t[0] - t[2]).norm()});
  const double area = normal.norm();
  return area > tolerance * longest ? Point3(normal / area) : Point3::Zero();
}

/// The plane of a triangle as seen along the axis nearest to its normal: its corners, projected to
/// two axes, are counter-clockwise.
class Chart {
 public:
  Chart(const Point3& origin, const Point3& normal) : origin_(origin), normal_(normal) {
    normal.cwiseAbs().maxCoeff(&axis_);
    u_ = (axis_ + 1) % 3;
    v_ = (axis_ + 2) % 3;
    if (normal[axis_] < 0) std::swap(u_, v_);
  }
  int axis() const { return axis_; }
  Eigen::Vector2d flat(const Point3& point) const { return {point[u_], point[v_]}; }
  Point3 lifted(const Eigen::Vector2d& flat) const {
    Point3 point;
    point[u_] = flat.x();
    point[v_] = flat.y();
    point[axis_] = origin_[axis_] - (normal_[u_] * (flat.x() - origin_[u_]) +
                                     normal_[v_] * (flat.y() - origin_[v_])) /
                                        normal_[axis_];
    return point;
  }

 private:
  Point3 origin_;
  Point3 normal_;
  int axis_ = 0;
  int u_ = 0;
  int v_ = 0;
};

/// How often what a surface encloses covers the two sides of a place on it.
struct Sides {
  int above = 0;
  int below = 0;

  bool isWithin() const { return above != 0 && below != 0; }
};

/// A surface, and how its triangles meet.
class Surface {
 public:
  Surface(std::span<const Point3> points, std::span<const Triangle> triangles, double tolerance)
      : points_(points),
        triangles_(triangles),
        tolerance_(tolerance),
        scale_(points, triangles),
        tree_(boxesOf(points, triangles, tolerance)) {
    normals_.reserve(triangles.size());
    for (const Triangle& triangle : triangles) {
      normals_.push_back(normalOf(cornersOf(triangle), tolerance));
    }
    fixed_.reserve(points.size());
    for (const Point3& point : points) fixed_.push_back(scale_.fixed(point));
  }

  bool hasArea(std::uint32_t triangle) const { return !normals_[triangle].isZero(); }
  std::array<Point3, 3> cornersOf(const Triangle& t) const {
    return {points_[t[0]], points_[t[1]], points_[t[2]]};
  }
  Chart chartOf(std::uint32_t triangle) const {
    return {points_[triangles_[triangle][0]], normals_[triangle]};
  }
  ConvexPolygon polygonOf(std::uint32_t triangle, const Chart& chart) const {
    const auto [a, b, c] = cornersOf(triangles_[triangle]);
    return {chart.flat(a), chart.flat(b), chart.flat(c)};
  }

  /// The places where other triangles meet one in more than shared vertices and edges.
  struct Meetings {
    bool any = false;
    std::vector<PlaneSegment> cuts;  ///< of them, those that cross it
  };

  Meetings meetingsOf(std::uint32_t triangle, const Chart& chart,
                      const ConvexPolygon& polygon) const {
    Meetings found;
    Bounds3 box;
    for (const std::uint32_t vertex : triangles_[triangle]) box.add(points_[vertex]);
    tree_.visitOverlapping(box, [&](std::uint32_t other) {
      if (other == triangle || !hasArea(other)) return;
      visitMeeting(triangle, other, [&](const Point3& from, const Point3& to) {
        const auto segment = within(polygon, {chart.flat(from), chart.flat(to)}, tolerance_);
        if (!segment) return;
        found.any = true;
        if (isCut(polygon, *segment, tolerance_)) found.cuts.push_back(*segment);
      });
    });
    return found;
  }

  /// The sides of a place on a triangle, which is away from its edges and from those of others.
  Sides sidesOf(std::uint32_t triangle, const Point3& place) const {
    const int w = chartOf(triangle).axis();
    const int u = (w + 1) % 3;
    const int v = (w + 2) % 3;
    const FixedPoint at = scale_.fixed(place);
    Bounds3 ray{place, place};
    ray.min[w] -= tolerance_;
    ray.max[w] = std::numeric_limits<double>::infinity();
    Sides sides;
    int through = normals_[triangle][w] > 0 ? 1 : -1;  // of all triangles at the place
    tree_.visitOverlapping(ray, [&](std::uint32_t other) {
      if (other == triangle) return;
      const Triangle& t = triangles_[other];
      const auto crossed = crossingOf({fixed_[t[0]], fixed_[t[1]], fixed_[t[2]]}, at, u, v);
      if (!crossed) return;
      const auto& [weights, up] = *crossed;
      const double height = weights[0] * points_[t[0]][w] + weights[1] * points_[t[1]][w] +
                            weights[2] * points_[t[2]][w] - place[w];
      // Planes within the tolerance can be so far apart along the axis.
      if (std::abs(height) <= 4 * tolerance_) {
        through += up ? 1 : -1;
      } else if (height > 0) {
        sides.above += up ? 1 : -1;
      }
    });
    sides.below = sides.above + through;
    return sides;
  }

 private:
  static std::vector<Bounds3> boxesOf(std::span<const Point3> points,
                                      std::span<const Triangle> triangles, double tolerance) {
    std::vector<Bounds3> boxes;
    boxes.reserve(triangles.size());
    for (const Triangle& triangle : triangles) {
      Bounds3& box = boxes.emplace_back();
      for (const std::uint32_t vertex : triangle) box.add(points[vertex]);
      box.min.array() -= tolerance;
      box.max.array() += tolerance;
    }
    return boxes;
  }

  /// The distances of a triangle's corners from the plane of another one: exactly 0 of those that
  /// they share.
  std::array<double, 3> distancesFrom(std::uint32_t plane, std::uint32_t triangle) const {
    const Triangle& base = triangles_[plane];
    std::array<double, 3> distances{};
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t corner = triangles_[triangle][i];
      if (std::ranges::find(base, corner) != base.end()) continue;
      distances[i] = normals_[plane].dot(points_[corner] - points_[base[0]]);
      if (std::abs(distances[i]) <= tolerance_) distances[i] = 0;
    }
    return distances;
  }

  /// Calls `visit(from, to)` for each segment in which `other` meets the plane of `triangle`, but
  /// for edges that they share.
  template <class Visit>
  void visitMeeting(std::uint32_t triangle, std::uint32_t other, const Visit& visit) const {
    const auto isApart = [](const std::array<double, 3>& d) {
      return (d[0] > 0 && d[1] > 0 && d[2] > 0) || (d[0] < 0 && d[1] < 0 && d[2] < 0);
    };
    const auto isFlat = [](const std::array<double, 3>& d) {
      return d[0] == 0 && d[1] == 0 && d[2] == 0;
    };
    const auto distances = distancesFrom(triangle, other);
    if (isApart(distances)) return;
    const auto back = distancesFrom(other, triangle);
    if (isApart(back)) return;
    const Triangle& t = triangles_[other];
    const auto isShared = [&](std::uint32_t vertex) {
      return std::ranges::find(triangles_[triangle], vertex) != triangles_[triangle].end();
    };
    if (isFlat(distances) || isFlat(back)) {
      for (int i = 0; i < 3; ++i) {
        const std::uint32_t from = t[i];
        const std::uint32_t to = t[(i + 1) % 3];
        if (isShared(from) && isShared(to)) continue;
        visit(points_[from], points_[to]);
      }
      return;
    }
    std::array<Point3, 3> ends;
    std::size_t count = 0;
    std::size_t shared = 0;
    for (int i = 0; i < 3; ++i) {
      const int next = (i + 1) % 3;
      if (distances[i] == 0) {
        ends[count++] = points_[t[i]];
        shared += isShared(t[i]) ? 1 : 0;
      } else if (distances[i] * distances[next] < 0) {
        const double part = distances[i] / (distances[i] - distances[next]);
        ends[count++] = points_[t[i]] + part * (points_[t[next]] - points_[t[i]]);
      }
    }
    if (count == 2 && shared < 2) visit(ends[0], ends[1]);
  }

  std::span<const Point3> points_;
  std::span<const Triangle> triangles_;
  double tolerance_;
  FixedScale scale_;
  model::BoxTree<3> tree_;
  std::vector<Point3> normals_;
  std::vector<FixedPoint> fixed_;
};

Point3 centreOf(const ConvexPolygon& polygon, const Chart& chart) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& corner : polygon) sum += corner;
  return chart.lifted(sum / static_cast<double>(polygon.size()));
}

/// Whether each triangle is within, of a surface whose triangles have nothing in common but shared
/// vertices and edges: then what is connected by edges of two triangles is all alike.
std::vector<char> withinByComponents(const Surface& surface, std::span<const Triangle> triangles) {
  model::UnionFind components(triangles.size());
  const model::SurfaceEdges edges = model::edgesOf(triangles);
  for (const model::EdgeSides& edge : edges.edges) {
    if (edge.end - edge.begin != 2) continue;
    components.unite(edges.sides[edge.begin] / 3, edges.sides[edge.begin + 1] / 3);
  }
  enum : char { kUnknown = 2 };
  std::vector<char> within(triangles.size(), kUnknown);
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    char& ofComponent = within[components.root(i)];
    if (ofComponent != kUnknown || !surface.hasArea(i)) continue;
    const Chart chart = surface.chartOf(i);
    ofComponent =
        surface.sidesOf(i, centreOf(surface.polygonOf(i, chart), chart)).isWithin() ? 1 : 0;
  }
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    const char ofComponent = within[components.root(i)];
    within[i] = ofComponent == kUnknown ? 0 : ofComponent;
  }
  return within;
}

/// A triangle that others cut: its pieces.
struct CutTriangle {
  std::vector<ConvexPolygon> pieces;
  std::vector<char> within;
};

}  // namespace

bool hasOverlappingComponents(std::span<const Point3> points, std::span<const Triangle> triangles,
                              double tolerance) {
  const model::SurfaceEdges edges = model::edgesOf(triangles);
  model::UnionFind components(triangles.size());
  for (const model::EdgeSides& edge : edges.edges) {
    if (edge.end - edge.begin > 2) return true;
    components.unite(edges.sides[edge.begin] / 3, edges.sides[edge.end - 1] / 3);
  }
  std::vector<std::uint32_t> numbers(triangles.size());
  std::vector<Bounds3> boxes;
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    const std::uint32_t root = components.root(i);
    if (root == i) {
      numbers[i] = static_cast<std::uint32_t>(boxes.size());
      boxes.emplace_back();
    }
    for (const std::uint32_t vertex : triangles[i]) boxes[numbers[root]].add(points[vertex]);
  }
  if (boxes.size() == 1) return false;
  for (Bounds3& box : boxes) {
    box.min.array() -= tolerance;
    box.max.array() += tolerance;
  }
  const model::BoxTree<3> tree(boxes);
  return std::ranges::any_of(boxes, [&](const Bounds3& box) {
    int overlapped = 0;
    tree.visitOverlapping(box, [&](std::uint32_t) { ++overlapped; });
    return overlapped > 1;
  });
}

UnionSurface unionSurface(std::span<const Point3> points, std::span<const Triangle> triangles,
                          double tolerance) {
  const Surface surface(points, triangles, tolerance);
  std::vector<std::vector<PlaneSegment>> cuts(triangles.size());
  std::atomic<bool> meets = false;
  std::atomic<std::uint64_t> cutCount = 0;
  model::forEach(triangles.size(), [&](std::size_t i) {
    const auto triangle = static_cast<std::uint32_t>(i);
    if (!surface.hasArea(triangle) || cutCount > kMostCuts) return;
    const Chart chart = surface.chartOf(triangle);
    Surface::Meetings found =
        surface.meetingsOf(triangle, chart, surface.polygonOf(triangle, chart));
    if (found.any) meets = true;
    cutCount += found.cuts.size();
    cuts[i] = std::move(found.cuts);
  });
  const auto whole = [&] {
    return UnionSurface{{points.begin(), points.end()}, {triangles.begin(), triangles.end()}, {}};
  };
  if (cutCount > kMostCuts) return whole();
  std::vector<CutTriangle> cut(triangles.size());
  model::forEach(triangles.size(), [&](std::size_t i) {
    if (cuts[i].empty()) return;
    const auto triangle = static_cast<std::uint32_t>(i);
    const ConvexPolygon polygon = surface.polygonOf(triangle, surface.chartOf(triangle));
    // Segments that do not cross each other need about two pieces each.
    cut[i].pieces = cutAlong(polygon, cuts[i], tolerance, 64 + 8 * cuts[i].size());
  });

  std::vector<char> within;
  if (!meets) {
    within = withinByComponents(surface, triangles);
  } else {
    within.resize(triangles.size());
    model::forEach(triangles.size(), [&](std::size_t i) {
      const auto triangle = static_cast<std::uint32_t>(i);
      if (!surface.hasArea(triangle)) return;
      const Chart chart = surface.chartOf(triangle);
      const auto isWithin = [&](const ConvexPolygon& polygon) {
        return static_cast<char>(surface.sidesOf(triangle, centreOf(polygon, chart)).isWithin());
      };
      if (cut[i].pieces.empty()) within[i] = isWithin(surface.polygonOf(triangle, chart));
      for (const ConvexPolygon& piece : cut[i].pieces) {
        cut[i].within.push_back(isWithin(piece));
      }
    });
  }

  UnionSurface parts;
  parts.points.assign(points.begin(), points.end());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const auto triangle = static_cast<std::uint32_t>(i);
    if (!surface.hasArea(triangle)) continue;
    const CutTriangle& pieces = cut[i];
    const bool alike =
        std::ranges::adjacent_find(pieces.within, std::not_equal_to<>()) == pieces.within.end();
    if (alike) {
      const bool isWithin = pieces.within.empty() ? within[i] != 0 : pieces.within.front() != 0;
      (isWithin ? parts.inner : parts.outer).push_back(triangles[i]);
      continue;
    }
    const Chart chart = surface.chartOf(triangle);
    for (std::size_t p = 0; p < pieces.pieces.size(); ++p) {
      const auto first = static_cast<std::uint32_t>(parts.points.size());
      for (const Eigen::Vector2d& corner : pieces.pieces[p]) {
        parts.points.push_back(chart.lifted(corner));
      }
      const auto corners = static_cast<std::uint32_t>(pieces.pieces[p].size());
      for (std::uint32_t k = 2; k < corners; ++k) {
        (pieces.within[p] != 0 ? parts.inner : parts.outer)
            .push_back({first, first + k - 1, first + k});
      }
    }
  }
  return parts.inner.empty() ? whole() : parts;
}

}  // namespace t4d::voxel4d
