#include "formats/triangle/polygon_triangulation.h"

#include <algorithm>

#include <Eigen/Geometry>

namespace t4d::formats {
namespace {

using model::Point3;

Point3 newellNormal(std::span<const Point3> vertices, std::span<const std::uint32_t> corners) {
  // Relative to the first corner, so that a polygon far from the origin loses no digits.
  const Point3& origin = vertices[corners[0]];
  Point3 normal = Point3::Zero();
  for (std::size_t i = 2; i < corners.size(); ++i) {
    normal += (vertices[corners[i - 1]] - origin).cross(vertices[corners[i]] - origin);
  }
  return normal;
}

}  // namespace

double PolygonTriangulator::turn(const Corner& a, const Corner& b, const Corner& c) const {
  return (b.x - a.x) * (c.y - b.y) - (b.y - a.y) * (c.x - b.x);
}

void PolygonTriangulator::judge(std::uint32_t corner) {
  Corner& b = corners_[corner];
  b.convex = turn(corners_[b.previous], b, corners_[b.next]) > 0;
}

/// A convex corner whose triangle holds no corner that is not convex, on its border neither: a
/// corner on a straight edge must not be cut off from it.
bool PolygonTriangulator::isEar(std::uint32_t corner) {
  const Corner& b = corners_[corner];
  if (!b.convex) return false;
  const Corner& a = corners_[b.previous];
  const Corner& c = corners_[b.next];
  std::erase_if(concave_,
                [&](std::uint32_t i) { return corners_[i].removed || corners_[i].convex; });
  workLeft_ -= std::min<std::uint64_t>(workLeft_, concave_.size() + 1);
  return std::none_of(concave_.begin(), concave_.end(), [&](std::uint32_t i) {
    const Corner& p = corners_[i];
    // Polygons with holes visit the ends of a bridge twice.
    const auto isAt = [&](const Corner& q) { return p.x == q.x && p.y == q.y; };
    if (isAt(a) || isAt(b) || isAt(c)) return false;
    return turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
  });
}

bool PolygonTriangulator::clipEars(std::vector<model::Triangle>& triangles) {
  std::size_t left = corners_.size();
  std::size_t misses = 0;
  std::uint32_t here = 1;  // so that the diagonal of a quadrilateral starts at its first corner
  // Without an ear, the polygon crosses itself or has no area: the rest becomes a fan.
  while (left > 3 && misses < left) {
    Corner& corner = corners_[here];
    if (workLeft_ == 0) return false;
    if (!isEar(here)) {
      ++misses;
      here = corner.next;
      continue;
    }
    triangles.push_back(
        {corners_[corner.previous].vertex, corner.vertex, corners_[corner.next].vertex});
    corner.removed = true;
    corners_[corner.previous].next = corner.next;
    corners_[corner.next].previous = corner.previous;
    for (const std::uint32_t neighbour : {corner.previous, corner.next}) {
      const bool was = corners_[neighbour].convex;
      judge(neighbour);
      if (was && !corners_[neighbour].convex) concave_.push_back(neighbour);
    }
    --left;
    misses = 0;
    here = corners_[corner.next].next;
  }
  const Corner& first = corners_[here];
  for (std::uint32_t b = first.next, c = corners_[b].next; c != here; b = c, c = corners_[c].next) {
    triangles.push_back({first.vertex, corners_[b].vertex, corners_[c].vertex});
  }
  return true;
}

bool PolygonTriangulator::add(std::span<const Point3> vertices,
                              std::span<const std::uint32_t> corners,
                              std::vector<model::Triangle>& triangles) {
  if (corners.size() == 3) {
    triangles.push_back({corners[0], corners[1], corners[2]});
    return true;
  }
  // Dropping the normal's largest coordinate shows a plane polygon without rounding.
  const Point3 normal = newellNormal(vertices, corners);
  int dropped = 0;
  normal.cwiseAbs().maxCoeff(&dropped);
  int u = (dropped + 1) % 3;
  int v = (dropped + 2) % 3;
  if (normal[dropped] < 0) std::swap(u, v);

  corners_.clear();
  const auto count = static_cast<std::uint32_t>(corners.size());
  for (std::uint32_t i = 0; i < count; ++i) {
    const Point3& p = vertices[corners[i]];
    corners_.push_back(
        {p[u], p[v], corners[i], (i + count - 1) % count, (i + 1) % count, false, false});
  }
  concave_.clear();
  for (std::uint32_t i = 0; i < count; ++i) {
    judge(i);
    if (!corners_[i].convex) concave_.push_back(i);
  }
  return clipEars(triangles);
}

}  // namespace t4d::formats
