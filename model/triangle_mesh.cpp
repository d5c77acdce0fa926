#include <algorithm>
#include <numeric>

#include <Eigen/Geometry>

#include "model/exact_sum.h"
#include "model/unit_scale.h"
#include "model/volume.h"
#include "t4d/surface.h"

namespace t4d::model {
namespace {

/// What the terms of a cross product of two vectors add up to without their signs.
Point3 sizeOfCross(const Point3& u, const Point3& v) {
  return {u.y() * v.z() + u.z() * v.y(), u.z() * v.x() + u.x() * v.z(),
          u.x() * v.y() + u.y() * v.x()};
}

double exactVolume(std::span<const Point3> vertices, std::span<const Triangle> triangles,
                   const Point3& middle) {
  ExactSum sum;
  std::array<std::array<ExactSum::Factor, 3>, 3> rows;
  for (const Triangle& triangle : triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Point3& vertex = vertices[triangle[i]];
      for (int axis = 0; axis < 3; ++axis) {
        rows[i][static_cast<std::size_t>(axis)] =
            ExactSum::Factor::difference(vertex[axis], middle[axis]);
      }
    }
    addDeterminant(sum, rows);
  }
  return sum.dividedBy(6);
}

double volumeAbout(std::span<const Point3> vertices, std::span<const Triangle> triangles,
                   const Bounds3& bounds) {
  const Point3 middle = 0.5 * bounds.min + 0.5 * bounds.max;
  double sum = 0;
  double magnitude = 0;  // of the terms of all determinants
  for (const auto& [a, b, c] : triangles) {
    const Point3 p = vertices[a] - middle;
    const Point3 q = vertices[b] - middle;
    const Point3 r = vertices[c] - middle;
    sum += p.dot(q.cross(r));
    magnitude += p.cwiseAbs().dot(sizeOfCross(q.cwiseAbs(), r.cwiseAbs()));
  }
  if (isPrecise(sum, magnitude)) return sum / 6;
  return exactVolume(vertices, triangles, middle);
}

}  // namespace

Bounds3 boundsOf(const TriangleMesh& mesh) {
  Bounds3 bounds;
  for (const Point3& vertex : mesh.vertices) bounds.add(vertex);
  return bounds;
}

double signedVolume(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) return 0;
  return volumeAbout(mesh.vertices, mesh.triangles, boundsOf(mesh));
}

double signedVolume(std::span<const Point3> vertices, std::span<const Triangle> triangles) {
  if (triangles.empty()) return 0;
  Bounds3 bounds;
  for (const Triangle& triangle : triangles) {
    for (const std::uint32_t corner : triangle) bounds.add(vertices[corner]);
  }
  return volumeAbout(vertices, triangles, bounds);
}

double surfaceArea(const TriangleMesh& mesh) {
  const UnitScale scale = UnitScale::of({&mesh});
  if (scale.changes()) return scale.fromUnit(surfaceArea(scale.toUnit(mesh)), 2);
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Point3& p = mesh.vertices[a];
    sum += (mesh.vertices[b] - p).cross(mesh.vertices[c] - p).norm();
  }
  return sum / 2;
}

bool isClosed(const TriangleMesh& mesh) {
  // The edges of each vertex to a larger one: that one, and in the low bit the direction.
  std::uint32_t last = 0;
  for (const Triangle& triangle : mesh.triangles) last = std::max(last, std::ranges::max(triangle));
  std::vector<std::size_t> ends(std::size_t{last} + 2);
  const auto eachEdge = [&](auto visit) {
    for (const Triangle& triangle : mesh.triangles) {
      for (int i = 0; i < 3; ++i) {
        const std::uint32_t from = triangle[i];
        const std::uint32_t to = triangle[i == 2 ? 0 : i + 1];
        visit(std::min(from, to), std::uint64_t{std::max(from, to)} << 1 | (from < to ? 1 : 0));
      }
    }
  };
  eachEdge([&](std::uint32_t smaller, std::uint64_t) { ++ends[smaller + 1]; });
  std::partial_sum(ends.begin(), ends.end(), ends.begin());
  std::vector<std::uint64_t> edges(ends.back());
  // Where the next edge goes, and in the end where those of a vertex end.
  ends.pop_back();
  eachEdge([&](std::uint32_t smaller, std::uint64_t edge) { edges[ends[smaller]++] = edge; });
  std::size_t begin = 0;
  for (const std::size_t end : ends) {
    std::sort(edges.begin() + static_cast<std::ptrdiff_t>(begin),
              edges.begin() + static_cast<std::ptrdiff_t>(end));
    while (begin < end) {
      const std::uint64_t larger = edges[begin] >> 1;
      std::int64_t balance = 0;
      for (; begin < end && edges[begin] >> 1 == larger; ++begin) {
        balance += (edges[begin] & 1) != 0 ? 1 : -1;
      }
      if (balance != 0) return false;
    }
  }
  return true;
}

}  // namespace t4d::model
