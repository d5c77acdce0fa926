#include "edit/solid_sample.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace t4d::edit {
namespace {

using model::Point3;

Point3 nearestOnSegment(const Point3& p, const Point3& a, const Point3& b) {
  const Point3 along = b - a;
  const double length2 = along.squaredNorm();
  return length2 > 0 ? Point3(a + std::clamp(along.dot(p - a) / length2, 0.0, 1.0) * along) : a;
}

Point3 nearestOnTriangle(const Point3& p, const std::array<Point3, 3>& corners) {
  const auto& [a, b, c] = corners;
  const Point3 normal = (b - a).cross(c - a);
  const double area2 = normal.squaredNorm();
  if (area2 > 0) {
    const double u = normal.dot((c - b).cross(p - b)) / area2;
    const double v = normal.dot((a - c).cross(p - c)) / area2;
    if (u >= 0 && v >= 0 && u + v <= 1) return u * a + v * b + (1 - u - v) * c;
  }
  Point3 best = nearestOnSegment(p, a, b);
  for (const Point3& other : {nearestOnSegment(p, b, c), nearestOnSegment(p, c, a)}) {
    if ((other - p).squaredNorm() < (best - p).squaredNorm()) best = other;
  }
  return best;
}

}  // namespace

SolidSample::SolidSample(model::TriangleMesh mesh)
    : mesh_(std::move(mesh)), bounds_(boundsOf(mesh_)), tree_(mesh_), winding_(mesh_) {}

SolidSample::Place SolidSample::at(const Point3& point) const {
  const auto [triangle, distance] = tree_.nearest(point);
  const auto& [a, b, c] = mesh_.triangles[triangle];
  const std::array<Point3, 3> corners = {mesh_.vertices[a], mesh_.vertices[b], mesh_.vertices[c]};
  Place place{distance, triangle, nearestOnTriangle(point, corners), Point3::Zero()};
  const bool inside = winding_.at(point) > 0.5;
  if (inside) place.distance = -distance;
  place.out = inside ? place.nearest - point : point - place.nearest;
  if (const double length = place.out.norm(); length > 0) {
    place.out /= length;
  } else {
    place.out = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
  }
  return place;
}

std::optional<double> SolidSample::wayOut(const Point3& point, const Point3& along, double keep,
                                          double most) const {
  // No point within the distance to the surface leaves or enters the solid, so steps of that size
  // miss nothing; the least step ends the approach.
  const double least = std::max(keep, most * 1e-4) / 8;
  double way = 0;
  while (way <= most) {
    const double distance = at(point + way * along).distance;
    if (distance >= keep) return way;
    way += std::max(distance < 0 ? -distance : keep - distance, least);
  }
  return std::nullopt;
}

bool isNear(const model::Bounds3& bounds, const Point3& point, double distance) {
  return ((point - bounds.min).array() >= -distance).all() &&
         ((bounds.max - point).array() >= -distance).all();
}

}  // namespace t4d::edit
