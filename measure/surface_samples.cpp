#include "measure/surface_samples.h"

#include <cmath>

namespace t4d::measure {

using model::Point3;

/// Sample k lies in the triangle where the cumulative area reaches (k + 1/2) / count of the total.
/// Positions within triangles are successive points of a low-discrepancy sequence in the unit
/// square (Roberts' R2, based on the plastic number), folded.
std::vector<SurfaceSample> surfaceSamples(const model::TriangleMesh& mesh, std::size_t count) {
  constexpr double kFirst = 0.7548776662466927;
  constexpr double kSecond = 0.5698402909980532;
  const double step = surfaceArea(mesh) / static_cast<double>(count);
  std::vector<SurfaceSample> samples;
  if (!(step > 0)) return samples;
  samples.reserve(count);
  double reached = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Point3& corner = mesh.vertices[a];
    const Point3 u = mesh.vertices[b] - corner;
    const Point3 v = mesh.vertices[c] - corner;
    const Point3 normal = u.cross(v);
    reached += normal.norm() / 2;
    while (samples.size() < count &&
           (static_cast<double>(samples.size()) + 0.5) * step <= reached) {
      const auto k = static_cast<double>(samples.size() + 1);
      double s = std::fmod(k * kFirst, 1.0);
      double t = std::fmod(k * kSecond, 1.0);
      if (s + t > 1) {
        s = 1 - s;
        t = 1 - t;
      }
      samples.push_back({corner + s * u + t * v, normal.normalized()});
    }
  }
  return samples;
}

}  // namespace t4d::measure
