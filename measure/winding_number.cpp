#include "measure/winding_number.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace t4d::measure {
namespace {

using model::Point3;

constexpr std::uint32_t kLeafOfWinding = 8;
/// A group is replaced by a dipole beyond so many radii of it. The error of a dipole falls with the
/// square: at 3 it is below a hundredth for half a sphere.
constexpr double kFarRadii = 3;

Point3 areaOf(const std::array<Point3, 3>& corners) {
  return 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]);
}

Point3 centreOf(const std::array<Point3, 3>& corners) {
  return (corners[0] + corners[1] + corners[2]) / 3;
}

}  // namespace

// The solid angle of van Oosterom and Strackee 1983, divided by 4 pi.
double WindingNumber::ofTriangle(const std::array<Point3, 3>& corners, const Point3& point) {
  const Point3 a = corners[0] - point;
  const Point3 b = corners[1] - point;
  const Point3 c = corners[2] - point;
  const double la = a.norm();
  const double lb = b.norm();
  const double lc = c.norm();
  const double triple = a.dot(b.cross(c));
  if (triple == 0) return 0;
  const double rest = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return std::atan2(triple, rest) / (2 * std::numbers::pi);
}

WindingNumber::WindingNumber(const model::TriangleMesh& mesh)
    : scale_(model::UnitScale::of({&mesh})) {
  assert(!mesh.triangles.empty());
  corners_.reserve(mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    corners_.push_back({scale_.toUnit(mesh.vertices[a]), scale_.toUnit(mesh.vertices[b]),
                        scale_.toUnit(mesh.vertices[c])});
  }
  build(0, static_cast<std::uint32_t>(corners_.size()));
}

void WindingNumber::build(std::uint32_t begin, std::uint32_t end) {
  const std::size_t self = nodes_.size();
  nodes_.emplace_back();
  Node node;
  model::Bounds3 ofCentres;
  double weight = 0;
  for (std::uint32_t i = begin; i < end; ++i) {
    const Point3 area = areaOf(corners_[i]);
    const Point3 centre = centreOf(corners_[i]);
    node.area += area;
    node.center += area.norm() * centre;
    weight += area.norm();
    ofCentres.add(centre);
  }
  node.center = weight > 0 ? Point3(node.center / weight) : ofCentres.min;
  for (std::uint32_t i = begin; i < end; ++i) {
    for (const Point3& corner : corners_[i]) {
      node.radius = std::max(node.radius, (corner - node.center).norm());
    }
  }
  if (end - begin <= kLeafOfWinding) {
    node.first = begin;
    node.count = end - begin;
    nodes_[self] = node;
    return;
  }
  int axis = 0;
  (ofCentres.max - ofCentres.min).maxCoeff(&axis);
  const std::uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(corners_.begin() + begin, corners_.begin() + middle, corners_.begin() + end,
                   [&](const auto& a, const auto& b) {
                     return a[0][axis] + a[1][axis] + a[2][axis] <
                            b[0][axis] + b[1][axis] + b[2][axis];
                   });
  build(begin, middle);
  node.first = static_cast<std::uint32_t>(nodes_.size());
  nodes_[self] = node;
  build(middle, end);
}

double WindingNumber::exactAt(const Point3& given) const {
  const Point3 point = scale_.toUnit(given);
  double sum = 0;
  for (const auto& corners : corners_) sum += ofTriangle(corners, point);
  return sum;
}

double WindingNumber::exactAt(const model::TriangleMesh& mesh, const Point3& point) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    sum += ofTriangle({mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]}, point);
  }
  return sum;
}

double WindingNumber::at(const Point3& given) const {
  const Point3 point = scale_.toUnit(given);
  // Halving keeps the tree's depth below 33, and each level leaves at most one pending node.
  constexpr std::size_t kMaxDepth = 40;
  std::array<std::uint32_t, kMaxDepth> waiting;
  std::size_t count = 0;
  waiting[count++] = 0;
  double sum = 0;
  while (count > 0) {
    const std::uint32_t index = waiting[--count];
    const Node& node = nodes_[index];
    const Point3 to = node.center - point;
    const double squared = to.squaredNorm();
    if (squared > kFarRadii * kFarRadii * node.radius * node.radius) {
      sum += node.area.dot(to) / (squared * std::sqrt(squared)) / (4 * std::numbers::pi);
    } else if (node.count > 0) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
        sum += ofTriangle(corners_[i], point);
      }
    } else {
      waiting[count++] = node.first;
      waiting[count++] = index + 1;
    }
  }
  return sum;
}

}  // namespace t4d::measure
