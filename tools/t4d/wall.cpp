#include "tools/t4d/wall.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "measure/surface_samples.h"
#include "measure/triangle_tree.h"
#include "slice/surface_motion.h"

namespace t4d::tools {
namespace {

using model::Point3;

/// How far along a ray a triangle that it meets from inside is; infinite if it misses it (Möller
/// and Trumbore 1997).
double distanceAlong(const Point3& from, const Point3& direction, const Point3& a, const Point3& b,
                     const Point3& c) {
  constexpr double kMiss = std::numeric_limits<double>::infinity();
  const Point3 u = b - a;
  const Point3 v = c - a;
  const Point3 p = direction.cross(v);
  const double volume = u.dot(p);
  // Leaves through the triangle, which faces outward.
  if (!(volume < 0)) return kMiss;
  const Point3 t = from - a;
  const double s = t.dot(p) / volume;
  const Point3 q = t.cross(u);
  const double r = direction.dot(q) / volume;
  if (s < 0 || r < 0 || s + r > 1) return kMiss;
  return v.dot(q) / volume;
}

/// The length of the normal inside the solid, from points that are even over the surface.
std::vector<double> thicknesses(const model::TriangleMesh& mesh) {
  constexpr std::size_t kRays = 2000;
  // Pieces of a ray across the whole mesh, so that few triangles are near each.
  constexpr int kPieces = 64;
  // A fraction of the extent: the triangle from which a ray starts is not met.
  constexpr double kRounding = 1e-9;
  const auto samples = measure::surfaceSamples(mesh, kRays);
  if (samples.empty()) return {};
  const measure::TriangleTree tree(mesh);
  const model::Bounds3 bounds = model::boundsOf(mesh);
  const double extent = (bounds.max - bounds.min).norm();
  const double step = extent / kPieces;
  std::vector<double> found;
  for (const measure::SurfaceSample& sample : samples) {
    const Point3 inward = -sample.normal;
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i <= kPieces && least > i * step; ++i) {
      model::Bounds3 piece;
      piece.add(sample.place + i * step * inward);
      piece.add(sample.place + (i + 1) * step * inward);
      tree.forEachReaching(piece, [&](std::uint32_t triangle) {
        const auto& [a, b, c] = mesh.triangles[triangle];
        const double distance = distanceAlong(sample.place, inward, mesh.vertices[a],
                                              mesh.vertices[b], mesh.vertices[c]);
        if (distance > kRounding * extent) least = std::min(least, distance);
      });
    }
    // A ray through an edge may miss both of its triangles, by rounding.
    if (std::isfinite(least)) found.push_back(least);
  }
  return found;
}

}  // namespace

double wallThickness(const model::TriangleMesh& mesh) {
  const std::vector<double> found = thicknesses(mesh);
  if (found.empty()) return 0;
  return std::accumulate(found.begin(), found.end(), 0.0) / static_cast<double>(found.size());
}

double thinWalls(const model::TriangleMesh& mesh, double thickness) {
  const std::vector<double> found = thicknesses(mesh);
  if (found.empty()) return 0;
  const auto thin = std::ranges::count_if(found, [&](double one) { return one < thickness; });
  return static_cast<double>(thin) / static_cast<double>(found.size());
}

double meanNormalSpeed(const slice::Slice& slice) {
  double sum = 0;
  double area = 0;
  for (std::size_t t = 0; t < slice.mesh.triangles.size(); ++t) {
    const double speed = slice.motion->speeds[t];
    if (!std::isfinite(speed)) continue;
    const double own = slice::areaVector(slice.mesh, slice.mesh.triangles[t]).norm();
    area += own;
    sum += own * std::abs(speed);
  }
  return area > 0 ? sum / area : 0;
}

}  // namespace t4d::tools
