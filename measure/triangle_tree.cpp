#include "measure/triangle_tree.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>

#include "measure/hull_distance.h"
#include "model/distance.h"

namespace t4d::measure {
namespace {

using model::Bounds3;
using model::Point3;
using model::squaredDistanceToSegment;

using Corners = std::array<Point3, 3>;

constexpr std::uint32_t kLeafTriangles = 4;

double squaredDistance(const Bounds3& box, const Point3& p) {
  return (box.min - p).cwiseMax(p - box.max).cwiseMax(0).squaredNorm();
}

double squaredDistance(const Bounds3& a, const Bounds3& b) {
  return (a.min - b.max).cwiseMax(b.min - a.max).cwiseMax(0).squaredNorm();
}

std::array<model::Point4, 3> atNoTime(const Corners& triangle) {
  std::array<model::Point4, 3> points;
  for (std::size_t i = 0; i < 3; ++i) points[i] << triangle[i], 0;
  return points;
}

/// Inside the prism over the triangle, the distance to its plane; elsewhere, the distance to its
/// edges. A triangle without area consists of its edges. Exactly 0 at a corner.
double squaredDistance(const Corners& t, const Point3& p) {
  if (p == t[0] || p == t[1] || p == t[2]) return 0;
  const Point3 normal = (t[1] - t[0]).cross(t[2] - t[0]);
  const double area = normal.squaredNorm();
  bool over = area > 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const Point3& a = t[i];
    const Point3& b = t[(i + 1) % 3];
    if (normal.cross(b - a).dot(p - a) >= 0) continue;
    over = false;
    nearest = std::min(nearest, squaredDistanceToSegment(p, a, b));
  }
  if (over) {
    const double height = normal.dot(p - t[0]);
    return height * height / area;
  }
  if (area > 0) return nearest;
  for (int i = 0; i < 3; ++i) {
    nearest = std::min(nearest, squaredDistanceToSegment(p, t[i], t[(i + 1) % 3]));
  }
  return nearest;
}

}  // namespace

TriangleTree::TriangleTree(const model::TriangleMesh& mesh)
    : scale_(model::UnitScale::of({&mesh})) {
  assert(!mesh.triangles.empty());
  std::vector<Point3> centres;
  centres.reserve(mesh.triangles.size());
  corners_.reserve(mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    const auto& [p, q, r] = corners_.emplace_back(
        std::array<Point3, 3>{scale_.toUnit(mesh.vertices[a]), scale_.toUnit(mesh.vertices[b]),
                              scale_.toUnit(mesh.vertices[c])});
    centres.push_back((p + q + r) / 3);
  }
  order_.resize(corners_.size());
  std::iota(order_.begin(), order_.end(), 0U);
  build(0, static_cast<std::uint32_t>(order_.size()), centres);
}

void TriangleTree::build(std::uint32_t begin, std::uint32_t end,
                         const std::vector<Point3>& centres) {
  const std::size_t self = nodes_.size();
  nodes_.emplace_back();
  Bounds3 bounds;
  Bounds3 ofCentres;
  for (std::uint32_t i = begin; i < end; ++i) {
    for (const Point3& corner : corners_[order_[i]]) bounds.add(corner);
    ofCentres.add(centres[order_[i]]);
  }
  nodes_[self].bounds = bounds;
  if (end - begin <= kLeafTriangles) {
    nodes_[self].first = begin;
    nodes_[self].count = end - begin;
    return;
  }
  int axis = 0;
  (ofCentres.max - ofCentres.min).maxCoeff(&axis);
  const std::uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](std::uint32_t a, std::uint32_t b) {
                     const double left = centres[a][axis];
                     const double right = centres[b][axis];
                     return left != right ? left < right : a < b;
                   });
  build(begin, middle, centres);
  nodes_[self].first = static_cast<std::uint32_t>(nodes_.size());
  build(middle, end, centres);
}

TriangleTree::Nearest TriangleTree::nearest(const Point3& point, double most) const {
  if (!scale_.changes()) return nearestInUnit(point, most);
  Nearest found = nearestInUnit(scale_.toUnit(point), scale_.toUnit(most));
  found.distance = scale_.fromUnit(found.distance);
  return found;
}

template <class SquaredDistance, class Visit>
void TriangleTree::visitNear(const SquaredDistance& toBox, double best, const Visit& visit) const {
  // Halving keeps the tree's depth below 33, and each level leaves at most one pending node.
  constexpr std::size_t kMaxDepth = 40;
  struct Waiting {
    std::uint32_t node;
    double squared;
  };
  std::array<Waiting, kMaxDepth> waiting;
  std::size_t count = 0;
  waiting[count++] = {0, toBox(nodes_[0].bounds)};
  while (count > 0) {
    const auto [index, squared] = waiting[--count];
    if (squared >= best) continue;
    const Node& node = nodes_[index];
    if (node.count > 0) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) best = visit(order_[i]);
      continue;
    }
    Waiting near = {index + 1, toBox(nodes_[index + 1].bounds)};
    Waiting far = {node.first, toBox(nodes_[node.first].bounds)};
    if (far.squared < near.squared) std::swap(near, far);
    if (far.squared < best) waiting[count++] = far;
    if (near.squared < best) waiting[count++] = near;
  }
}

TriangleTree::Nearest TriangleTree::nearestInUnit(const Point3& point, double most) const {
  std::uint32_t nearest = 0;
  double best = most * most;
  visitNear([&](const Bounds3& box) { return squaredDistance(box, point); }, best,
            [&](std::uint32_t triangle) {
              const double d = squaredDistance(corners_[triangle], point);
              if (d < best) {
                best = d;
                nearest = triangle;
              }
              return best;
            });
  return {nearest, std::sqrt(best)};
}

double TriangleTree::distanceFrom(const Corners& triangle, double most) const {
  const std::array<model::Point4, 3> hull = atNoTime(
      {scale_.toUnit(triangle[0]), scale_.toUnit(triangle[1]), scale_.toUnit(triangle[2])});
  Bounds3 box;
  for (const model::Point4& corner : hull) box.add(Point3(corner.head<3>()));
  double best = scale_.toUnit(most);
  visitNear([&](const Bounds3& other) { return squaredDistance(other, box); }, best * best,
            [&](std::uint32_t other) {
              const auto found = distanceOf(hull, atNoTime(corners_[other]), best);
              best = std::min(best, std::max(0.0, found->lowerBound));
              return best * best;
            });
  return scale_.fromUnit(best);
}

double TriangleTree::distanceTo(std::uint32_t triangle, const Point3& point) const {
  return scale_.fromUnit(std::sqrt(squaredDistance(corners_[triangle], scale_.toUnit(point))));
}

}  // namespace t4d::measure
