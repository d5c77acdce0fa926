#include "measure/distance_quantile.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "measure/triangle_tree.h"

namespace t4d::measure {
namespace {

constexpr std::size_t kSamples = 10'000;

/// Sample k lies in the triangle where the cumulative area reaches (k + 1/2) / kSamples of the
/// total, so the number of samples in a triangle is proportional to its area, to within one.
/// Positions within triangles are successive points of a low-discrepancy sequence in the unit
/// square (Roberts' R2, based on the plastic number), folded.
std::vector<model::Point3> samplesOf(const model::TriangleMesh& mesh) {
  constexpr double kFirst = 0.7548776662466927;
  constexpr double kSecond = 0.5698402909980532;
  const double total = surfaceArea(mesh);
  std::vector<model::Point3> samples;
  double reached = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const model::Point3& corner = mesh.vertices[a];
    const Eigen::Vector3d u = mesh.vertices[b] - corner;
    const Eigen::Vector3d v = mesh.vertices[c] - corner;
    reached += 0.5 * u.cross(v).norm();
    while (samples.size() < kSamples &&
           (static_cast<double>(samples.size()) + 0.5) / kSamples * total <= reached) {
      const auto k = static_cast<double>(samples.size() + 1);
      double s = std::fmod(k * kFirst, 1.0);
      double t = std::fmod(k * kSecond, 1.0);
      if (s + t > 1) {
        s = 1 - s;
        t = 1 - t;
      }
      samples.push_back(corner + s * u + t * v);
    }
  }
  return samples;
}

}  // namespace

double distanceQuantile(const model::TriangleMesh& mesh, const model::TriangleMesh& other,
                        double fraction) {
  if (other.triangles.empty()) return 0;
  std::vector<double> distances;
  const TriangleTree tree(other);
  for (const model::Point3& point : samplesOf(mesh)) {
    distances.push_back(tree.nearest(point).distance);
  }
  if (distances.empty()) return 0;
  const double last = static_cast<double>(distances.size() - 1);
  const auto at = static_cast<std::ptrdiff_t>(std::ceil(std::clamp(fraction, 0.0, 1.0) * last));
  std::nth_element(distances.begin(), distances.begin() + at, distances.end());
  return distances[static_cast<std::size_t>(at)];
}

}  // namespace t4d::measure
