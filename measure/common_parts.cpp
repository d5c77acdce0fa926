#include "measure/common_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <unordered_map>
#include <utility>

#include "measure/triangle_tree.h"
#include "measure/winding_number.h"
#include "model/surface_edges.h"
#include "model/unit_scale.h"

namespace t4d::measure {
namespace {

using Eigen::Vector3d;
using model::Bounds3;
using model::Point3;
using model::Triangle;
using model::TriangleMesh;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
/// A determinant of three differences is computed with at most a dozen roundings a term.
constexpr double kDeterminantError = 16 * kEpsilon;

/// A piece of an edge of the polyhedron.
struct CommonEdge {
  std::vector<Point3> points;
  Bounds3 bounds;

  void add(const Point3& point) {
    points.push_back(point);
    bounds.add(point);
  }
};

/// Whether a triangle is no higher than some roundings of coordinates: its plane is not known, and
/// the triangles beside it say as much. Slices have such slivers at layers.
bool isSliver(const std::array<Point3, 3>& t, double rounding) {
  constexpr double kMostRoundings = 1024;
  const Vector3d u = t[1] - t[0];
  const Vector3d v = t[2] - t[0];
  const double longest = std::max({u.norm(), v.norm(), (v - u).norm()});
  return u.cross(v).norm() <= kMostRoundings * rounding * longest;
}

/// The triangles of a surface that reach a box, but for slivers, with their edges.
class NearSurface {
 public:
  NearSurface(const TriangleMesh& mesh, const Bounds3& box, double rounding)
      : near_{mesh.vertices, {}, {}} {
    for (const Triangle& triangle : mesh.triangles) {
      Bounds3 own;
      for (const std::uint32_t corner : triangle) own.add(mesh.vertices[corner]);
      if ((own.min.array() <= box.max.array()).all() &&
          (own.max.array() >= box.min.array()).all() &&
          !isSliver({point(triangle[0]), point(triangle[1]), point(triangle[2])}, rounding)) {
        near_.triangles.push_back(triangle);
      }
    }
    edges_ = model::edgesOf(near_.triangles);
  }

  const TriangleMesh& mesh() const { return near_; }
  const std::vector<model::EdgeSides>& edges() const { return edges_.edges; }
  /// The triangles at an edge, as sides of it.
  std::span<const std::uint32_t> sidesOf(const model::EdgeSides& edge) const {
    return std::span(edges_.sides).subspan(edge.begin, edge.end - edge.begin);
  }
  const Point3& point(std::uint32_t vertex) const { return near_.vertices[vertex]; }
  std::array<Point3, 3> corners(std::uint32_t triangle) const {
    const auto& [a, b, c] = near_.triangles[triangle];
    return {point(a), point(b), point(c)};
  }

 private:
  TriangleMesh near_;
  model::SurfaceEdges edges_;
};

/// Where an edge meets a triangle, as fractions of the edge: the first and the last place.
struct EdgeHit {
  double first = 0;
  double last = 0;
};

/// Meetings and positions of triangles, up to the rounding of coordinates.
class Touching {
 public:
  explicit Touching(double rounding) : rounding_(rounding) {}

  /// The signed heights of points above the plane of a triangle, times twice its area; 0 within the
  /// rounding.
  double heightOf(const Point3& point, const std::array<Point3, 3>& t) const {
    const Vector3d u = t[1] - t[0];
    const Vector3d v = t[2] - t[0];
    const Vector3d normal = u.cross(v);
    const Vector3d to = point - t[0];
    const double height = normal.dot(to);
    const double error =
        rounding_ * normal.norm() + kDeterminantError * u.norm() * v.norm() * to.norm();
    return std::abs(height) <= error ? 0 : height;
  }

  /// Includes edges that only touch the triangle.
  std::optional<EdgeHit> hitOf(const Point3& p, const Point3& q,
                               const std::array<Point3, 3>& t) const {
    const double atP = heightOf(p, t);
    const double atQ = heightOf(q, t);
    if ((atP > 0 && atQ > 0) || (atP < 0 && atQ < 0)) return std::nullopt;
    if (atP == 0 && atQ == 0) return hitInPlane(p, q, t);
    const double sign = atQ > atP ? 1 : -1;
    const Vector3d along = q - p;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d a = t[k] - p;
      const Vector3d b = t[(k + 1) % 3] - p;
      const double error = kDeterminantError * along.norm() * a.norm() * b.norm() +
                           rounding_ * along.norm() * (b - a).norm();
      if (sign * along.dot(a.cross(b)) < -error) return std::nullopt;
    }
    const double at = atP / (atP - atQ);
    return EdgeHit{at, at};
  }

  /// Whether two triangles that meet may bound a common part there: not if one is on the outer side
  /// of the other.
  bool mayBoundTogether(const std::array<Point3, 3>& s, const std::array<Point3, 3>& t) const {
    const auto isOutside = [&](const std::array<Point3, 3>& one, const std::array<Point3, 3>& of,
                               bool& inPlane) {
      bool outside = true;
      inPlane = true;
      for (const Point3& corner : one) {
        const double height = heightOf(corner, of);
        outside = outside && height >= 0;
        inPlane = inPlane && height == 0;
      }
      return outside && !inPlane;
    };
    bool inPlane = false;
    if (isOutside(s, t, inPlane)) return false;
    const auto normalOf = [](const std::array<Point3, 3>& one) -> Vector3d {
      return (one[1] - one[0]).cross(one[2] - one[0]);
    };
    if (inPlane) return normalOf(s).dot(normalOf(t)) > 0;
    return !isOutside(t, s, inPlane);
  }

 private:
  /// The hit of an edge in the plane of the triangle.
  std::optional<EdgeHit> hitInPlane(const Point3& p, const Point3& q,
                                    const std::array<Point3, 3>& t) const {
    const Vector3d normal = (t[1] - t[0]).cross(t[2] - t[0]);
    EdgeHit hit{0, 1};
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d inward = normal.cross(t[(k + 1) % 3] - t[k]);
      const double slack = rounding_ * inward.norm();
      const double atP = inward.dot(p - t[k]) + slack;
      const double atQ = inward.dot(q - t[k]) + slack;
      if (atP < 0 && atQ < 0) return std::nullopt;
      if (atP < 0) hit.first = std::max(hit.first, atP / (atP - atQ));
      if (atQ < 0) hit.last = std::min(hit.last, atP / (atP - atQ));
    }
    return hit.first <= hit.last ? std::optional(hit) : std::nullopt;
  }

  double rounding_;
};

/// The edges of what two solids have in common.
class CommonEdges {
 public:
  CommonEdges(const TriangleMesh& a, const TriangleMesh& b, const Bounds3& box)
      : CommonEdges(a, b, box,
                    kCoordinateRounding *
                        std::max(box.min.cwiseAbs().maxCoeff(), box.max.cwiseAbs().maxCoeff())) {}

  std::vector<CommonEdge> find() {
    addEdgesOf(a_, b_, windingB_, /*isA=*/true);
    addEdgesOf(b_, a_, windingA_, /*isA=*/false);
    std::vector<CommonEdge> all = std::move(pieces_);
    for (auto& [pair, crossing] : crossings_) {
      if (crossing.bounds) all.push_back(std::move(crossing.edge));
    }
    return all;
  }

 private:
  static constexpr double kCoordinateRounding = 64 * kEpsilon;

  CommonEdges(const TriangleMesh& a, const TriangleMesh& b, const Bounds3& box, double rounding)
      : a_(a, box, rounding),
        b_(b, box, rounding),
        windingA_(a),
        windingB_(b),
        touching_(rounding) {}

  /// The crossing of two triangles that meet.
  struct Crossing {
    bool bounds = false;  // a common part
    CommonEdge edge;
  };

  /// The side of the other surface on which a vertex lies.
  enum class Side : std::uint8_t { Unknown, Outside, Inside };

  /// Not for points on the surface; the number is within a few hundredths.
  static bool isInside(const WindingNumber& winding, const Point3& point) {
    constexpr double kInside = 0.85;
    return winding.at(point) > kInside;
  }

  void addEdgesOf(const NearSurface& surface, const NearSurface& other,
                  const WindingNumber& winding, bool isA) {
    std::optional<TriangleTree> tree;
    if (!other.mesh().triangles.empty()) tree.emplace(other.mesh());
    std::vector<Side> sides(surface.mesh().vertices.size(), Side::Unknown);
    for (const model::EdgeSides& edge : surface.edges()) {
      const Point3& p = surface.point(edge.low);
      const Point3& q = surface.point(edge.high);
      std::vector<double> ends = {0, 1};
      bool touched = false;
      Bounds3 box;
      box.add(p);
      box.add(q);
      if (tree) {
        tree->forEachReaching(box, [&](std::uint32_t triangle) {
          const auto hit = touching_.hitOf(p, q, other.corners(triangle));
          if (!hit) return;
          touched = true;
          for (const double at : {hit->first, hit->last}) {
            ends.push_back(at);
            for (const std::uint32_t side : surface.sidesOf(edge)) {
              const std::uint32_t own = side / 3;
              addCrossing(isA ? own : triangle, isA ? triangle : own, p + at * (q - p));
            }
          }
        });
      }
      if (!touched) {
        addWhole(surface, edge, winding, sides);
        continue;
      }
      std::ranges::sort(ends);
      for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
        if (!(ends[i] < ends[i + 1])) continue;
        if (!isInside(winding, p + std::midpoint(ends[i], ends[i + 1]) * (q - p))) continue;
        pieces_.emplace_back();
        for (const double at : {ends[i], ends[i + 1]}) pieces_.back().add(p + at * (q - p));
      }
    }
  }

  /// Adds an edge that does not meet the other surface, if it is inside.
  void addWhole(const NearSurface& surface, const model::EdgeSides& edge,
                const WindingNumber& winding, std::vector<Side>& sides) {
    // Both ends are on the same side.
    Side side = std::max(sides[edge.low], sides[edge.high]);
    const Point3& p = surface.point(edge.low);
    const Point3& q = surface.point(edge.high);
    if (side == Side::Unknown) {
      side = isInside(winding, (p + q) / 2) ? Side::Inside : Side::Outside;
    }
    sides[edge.low] = sides[edge.high] = side;
    if (side == Side::Outside) return;
    pieces_.emplace_back();
    pieces_.back().add(p);
    pieces_.back().add(q);
  }

  void addCrossing(std::uint32_t ofA, std::uint32_t ofB, const Point3& point) {
    const auto [found, added] = crossings_.try_emplace(std::uint64_t{ofA} << 32 | ofB);
    Crossing& crossing = found->second;
    if (added) crossing.bounds = touching_.mayBoundTogether(a_.corners(ofA), b_.corners(ofB));
    if (crossing.bounds) crossing.edge.add(point);
  }

  NearSurface a_;
  NearSurface b_;
  WindingNumber windingA_;
  WindingNumber windingB_;
  Touching touching_;
  std::vector<CommonEdge> pieces_;
  std::unordered_map<std::uint64_t, Crossing> crossings_;  // by pairs of triangles
};

/// Divides edges where planes across an axis lie between them, and adds the parts.
void divide(std::span<CommonEdge> edges, std::vector<CommonPart>& parts) {
  Bounds3 bounds;
  for (const CommonEdge& edge : edges) bounds.add(edge.bounds);
  const auto gapsAlong = [&](int axis, const auto& visit) {
    std::ranges::sort(edges, [&](const CommonEdge& p, const CommonEdge& q) {
      return std::pair(p.bounds.min[axis], p.bounds.max[axis]) <
             std::pair(q.bounds.min[axis], q.bounds.max[axis]);
    });
    double reached = edges.front().bounds.max[axis];
    for (std::size_t i = 1; i < edges.size(); ++i) {
      visit(i, edges[i].bounds.min[axis] - reached);
      reached = std::max(reached, edges[i].bounds.max[axis]);
    }
  };
  int best = -1;
  double widest = kLeastGapOfParts;
  for (int axis = 0; axis < 3; ++axis) {
    const double size = bounds.max[axis] - bounds.min[axis];
    gapsAlong(axis, [&](std::size_t /*at*/, double gap) {
      if (!(gap > widest * size)) return;
      widest = gap / size;
      best = axis;
    });
  }
  if (best < 0) {
    CommonPart& part = parts.emplace_back();
    part.bounds = bounds;
    for (const CommonEdge& edge : edges) {
      part.corners.insert(part.corners.end(), edge.points.begin(), edge.points.end());
    }
    return;
  }
  const double least = kLeastGapOfParts * (bounds.max[best] - bounds.min[best]);
  std::vector<std::size_t> begins = {0};
  gapsAlong(best, [&](std::size_t at, double gap) {
    if (gap > least) begins.push_back(at);
  });
  begins.push_back(edges.size());
  for (std::size_t k = 0; k + 1 < begins.size(); ++k) {
    divide(edges.subspan(begins[k], begins[k + 1] - begins[k]), parts);
  }
}

}  // namespace

std::vector<CommonPart> commonParts(const TriangleMesh& a, const TriangleMesh& b) {
  if (a.triangles.empty() || b.triangles.empty()) return {};
  const model::UnitScale scale = model::UnitScale::of({&a, &b});
  if (scale.changes()) {
    std::vector<CommonPart> parts = commonParts(scale.toUnit(a), scale.toUnit(b));
    for (CommonPart& part : parts) {
      for (Point3& corner : part.corners) corner = scale.fromUnit(corner);
      part.bounds = {scale.fromUnit(part.bounds.min), scale.fromUnit(part.bounds.max)};
    }
    return parts;
  }
  Bounds3 box = boundsOf(a);
  const Bounds3 other = boundsOf(b);
  box.min = box.min.cwiseMax(other.min);
  box.max = box.max.cwiseMin(other.max);
  if (box.empty()) return {};
  std::vector<CommonEdge> edges = CommonEdges(a, b, box).find();
  if (edges.empty()) return {};
  std::vector<CommonPart> parts;
  divide(edges, parts);
  return parts;
}

}  // namespace t4d::measure
