#include "slice/merge_coplanar.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "t4d/mesh.h"

namespace t4d::slice {
namespace {

using model::Attribute;
using model::Point3;
using model::Triangle;

/// A coordinate of a slice is a few roundings away from its place: a product, a sum, and the same
/// at each end of its edge.
constexpr double kRoundings = 16;

class Merger {
 public:
  Merger(model::TriangleMesh& mesh, bool keepAttributes)
      : mesh_(mesh), keepAttributes_(keepAttributes) {}

  CoplanarMerge merge() {
    CoplanarMerge made;
    made.trianglesBefore = mesh_.triangles.size();
    const model::Bounds3 bounds = boundsOf(mesh_);
    if (mesh_.triangles.empty()) return made;
    const double farthest =
        std::max(bounds.min.cwiseAbs().maxCoeff(), bounds.max.cwiseAbs().maxCoeff());
    tolerance_ = kRoundings * std::numeric_limits<double>::epsilon() * farthest;
    around_.resize(mesh_.vertices.size());
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      for (const std::uint32_t corner : mesh_.triangles[t]) around_[corner].push_back(t);
    }
    findParts();
    removeVertices();
    compact();
    made.tolerance = tolerance_;
    made.distance = distance_;
    return made;
  }

 private:
  Point3 normalOf(const Triangle& triangle) const {
    const auto& v = mesh_.vertices;
    return (v[triangle[1]] - v[triangle[0]]).cross(v[triangle[2]] - v[triangle[0]]);
  }

  double longestEdge(const Triangle& triangle) const {
    double longest = 0;
    for (int i = 0; i < 3; ++i) {
      longest = std::max(
          longest, (mesh_.vertices[triangle[i]] - mesh_.vertices[triangle[(i + 1) % 3]]).norm());
    }
    return longest;
  }

  /// The triangles at the edge from `a` to `b`.
  std::vector<std::uint32_t> trianglesAt(std::uint32_t a, std::uint32_t b) const {
    std::vector<std::uint32_t> found;
    for (const std::uint32_t t : around_[a]) {
      if (std::ranges::find(mesh_.triangles[t], b) != mesh_.triangles[t].end()) found.push_back(t);
    }
    return found;
  }

  bool sameAttributes(std::uint32_t a, std::uint32_t b) const {
    if (!keepAttributes_) return true;
    return std::ranges::all_of(mesh_.attributes, [&](const Attribute& attribute) {
      return attribute.domain != model::Domain::Cell ||
             std::memcmp(attribute.row(a), attribute.row(b), attribute.rowBytes()) == 0;
    });
  }

  /// Grows parts from the largest triangles, whose planes are known best.
  void findParts() {
    const std::size_t count = mesh_.triangles.size();
    std::vector<double> areas(count);
    for (std::size_t i = 0; i < count; ++i) areas[i] = normalOf(mesh_.triangles[i]).norm();
    std::vector<std::uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0U);
    std::ranges::stable_sort(order, [&](auto a, auto b) { return areas[a] > areas[b]; });
    partOf_.assign(count, model::kNoIndex);
    std::vector<std::uint32_t> open;
    for (const std::uint32_t seed : order) {
      if (partOf_[seed] != model::kNoIndex) continue;
      const auto part = static_cast<std::uint32_t>(normals_.size());
      const Point3 normal = normalOf(mesh_.triangles[seed]).stableNormalized();
      const Point3& origin = mesh_.vertices[mesh_.triangles[seed][0]];
      normals_.push_back(normal);
      origins_.push_back(origin);
      partOf_[seed] = part;
      open.assign(1, seed);
      while (!open.empty()) {
        const std::uint32_t t = open.back();
        open.pop_back();
        for (int i = 0; i < 3; ++i) {
          const Triangle& triangle = mesh_.triangles[t];
          for (const std::uint32_t next : trianglesAt(triangle[i], triangle[(i + 1) % 3])) {
            if (partOf_[next] != model::kNoIndex || !liesOn(next, normal, origin) ||
                !sameAttributes(seed, next)) {
              continue;
            }
            partOf_[next] = part;
            open.push_back(next);
          }
        }
      }
    }
  }

  bool liesOn(std::uint32_t t, const Point3& normal, const Point3& origin) const {
    const Triangle& triangle = mesh_.triangles[t];
    for (const std::uint32_t corner : triangle) {
      if (std::abs(normal.dot(mesh_.vertices[corner] - origin)) > tolerance_) return false;
    }
    // Slivers have no direction to speak of.
    const Point3 own = normalOf(triangle);
    return own.dot(normal) > 0 || own.norm() <= tolerance_ * longestEdge(triangle);
  }

  /// The vertices that a vertex may be merged into; empty if it must stay.
  std::vector<std::uint32_t> targetsOf(std::uint32_t vertex) const {
    std::vector<std::uint32_t> parts;
    std::vector<std::uint32_t> neighbors;
    for (const std::uint32_t t : around_[vertex]) {
      if (std::ranges::find(parts, partOf_[t]) == parts.end()) parts.push_back(partOf_[t]);
      for (const std::uint32_t corner : mesh_.triangles[t]) {
        if (corner != vertex) neighbors.push_back(corner);
      }
    }
    std::ranges::sort(neighbors);
    neighbors.erase(std::unique(neighbors.begin(), neighbors.end()), neighbors.end());
    // Around a vertex inside a closed surface there are as many edges as triangles.
    if (parts.empty() || parts.size() > 2 || neighbors.size() != around_[vertex].size()) return {};
    std::vector<std::uint32_t> between;  // neighbours along the border of two parts
    for (const std::uint32_t neighbor : neighbors) {
      const auto two = trianglesAt(vertex, neighbor);
      if (two.size() != 2) return {};
      if (partOf_[two[0]] != partOf_[two[1]]) between.push_back(neighbor);
    }
    if (parts.size() == 1) return neighbors;
    if (between.size() != 2) return {};
    const Point3& at = mesh_.vertices[vertex];
    const Point3 a = mesh_.vertices[between[0]] - at;
    const Point3 b = mesh_.vertices[between[1]] - at;
    const double length = (a - b).norm();
    const bool straight = a.dot(b) < 0 && a.cross(b).norm() <= tolerance_ * length;
    return straight ? between : std::vector<std::uint32_t>();
  }

  /// How well shaped the worst triangle is if `vertex` moves to `target`: its height over its
  /// longest edge. Nothing if it cannot move there.
  std::optional<double> shapeAfter(std::uint32_t vertex, std::uint32_t target) const {
    std::vector<std::uint32_t> common;
    for (const std::uint32_t t : around_[vertex]) {
      for (const std::uint32_t corner : mesh_.triangles[t]) {
        if (corner != vertex && corner != target) common.push_back(corner);
      }
    }
    std::ranges::sort(common);
    common.erase(std::unique(common.begin(), common.end()), common.end());
    std::vector<std::uint32_t> others;
    for (const std::uint32_t t : around_[target]) {
      for (const std::uint32_t corner : mesh_.triangles[t]) {
        if (corner != vertex && corner != target) others.push_back(corner);
      }
    }
    std::ranges::sort(others);
    others.erase(std::unique(others.begin(), others.end()), others.end());
    std::vector<std::uint32_t> shared;
    std::ranges::set_intersection(common, others, std::back_inserter(shared));
    // The link condition: only the two triangles between them have both as neighbours.
    if (shared.size() != 2) return std::nullopt;
    double worst = std::numeric_limits<double>::infinity();
    for (const std::uint32_t t : around_[vertex]) {
      Triangle moved = mesh_.triangles[t];
      if (std::ranges::find(moved, target) != moved.end()) continue;
      std::ranges::replace(moved, vertex, target);
      const double area = normalOf(moved).dot(normals_[partOf_[t]]);
      const double longest = longestEdge(moved);
      if (!(area > tolerance_ * longest)) return std::nullopt;
      worst = std::min(worst, area / (longest * longest));
    }
    return worst;
  }

  void removeVertices() {
    std::vector<std::uint32_t> queue(mesh_.vertices.size());
    std::iota(queue.begin(), queue.end(), 0U);
    std::vector<bool> waits(mesh_.vertices.size(), true);
    for (std::size_t next = 0; next < queue.size(); ++next) {
      const std::uint32_t vertex = queue[next];
      waits[vertex] = false;
      std::optional<double> best;
      std::uint32_t to = model::kNoIndex;
      for (const std::uint32_t target : targetsOf(vertex)) {
        const auto shape = shapeAfter(vertex, target);
        if (!shape || (best && *shape <= *best)) continue;
        best = shape;
        to = target;
      }
      if (!best) continue;
      collapse(vertex, to);
      // The neighbours may now be able to go, too.
      for (const std::uint32_t t : around_[to]) {
        for (const std::uint32_t corner : mesh_.triangles[t]) {
          if (waits[corner]) continue;
          waits[corner] = true;
          queue.push_back(corner);
        }
      }
    }
  }

  void collapse(std::uint32_t vertex, std::uint32_t target) {
    for (const std::uint32_t t : around_[vertex]) {
      const std::uint32_t part = partOf_[t];
      distance_ = std::max(distance_,
                           std::abs(normals_[part].dot(mesh_.vertices[vertex] - origins_[part])));
      Triangle& triangle = mesh_.triangles[t];
      if (std::ranges::find(triangle, target) != triangle.end()) {
        for (const std::uint32_t corner : triangle) {
          if (corner != vertex) std::erase(around_[corner], t);
        }
        partOf_[t] = model::kNoIndex;
      } else {
        std::ranges::replace(triangle, vertex, target);
        around_[target].push_back(t);
      }
    }
    around_[vertex].clear();
  }

  void compact() {
    std::vector<std::uint32_t> kept;
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      if (partOf_[t] != model::kNoIndex) kept.push_back(t);
    }
    std::vector<std::uint32_t> number(mesh_.vertices.size(), model::kNoIndex);
    std::vector<std::uint32_t> vertices;
    for (std::uint32_t i = 0; i < mesh_.vertices.size(); ++i) {
      if (around_[i].empty()) continue;
      number[i] = static_cast<std::uint32_t>(vertices.size());
      vertices.push_back(i);
    }
    model::TriangleMesh made;
    for (const std::uint32_t i : vertices) made.vertices.push_back(mesh_.vertices[i]);
    for (const std::uint32_t t : kept) {
      const auto& [a, b, c] = mesh_.triangles[t];
      made.triangles.push_back({number[a], number[b], number[c]});
    }
    for (const Attribute& attribute : mesh_.attributes) {
      const bool ofCells = attribute.domain == model::Domain::Cell;
      if (ofCells && !keepAttributes_) continue;
      Attribute rows{attribute.name, attribute.domain, attribute.type, attribute.components, {}};
      for (const std::uint32_t row : ofCells ? kept : vertices) {
        rows.values.insert(rows.values.end(), attribute.row(row),
                           attribute.row(row) + attribute.rowBytes());
      }
      made.attributes.push_back(std::move(rows));
    }
    mesh_ = std::move(made);
  }

  model::TriangleMesh& mesh_;
  bool keepAttributes_;
  double tolerance_ = 0;
  double distance_ = 0;
  std::vector<std::vector<std::uint32_t>> around_;  // the triangles of each vertex
  std::vector<std::uint32_t> partOf_;               // of each triangle; model::kNoIndex: it is gone
  std::vector<Point3> normals_;                     // of the planes of parts
  std::vector<Point3> origins_;
};

}  // namespace

CoplanarMerge mergeCoplanar(model::TriangleMesh& mesh, bool keepAttributes) {
  return Merger(mesh, keepAttributes).merge();
}

}  // namespace t4d::slice
