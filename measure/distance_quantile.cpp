#include "measure/distance_quantile.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "measure/surface_samples.h"
#include "measure/triangle_tree.h"

namespace t4d::measure {
double distanceQuantile(const model::TriangleMesh& mesh, const model::TriangleMesh& other,
                        double fraction) {
  if (other.triangles.empty()) return 0;
  std::vector<double> distances;
  const TriangleTree tree(other);
  for (const SurfaceSample& sample : surfaceSamples(mesh, kSurfaceSamples)) {
    distances.push_back(tree.nearest(sample.place).distance);
  }
  if (distances.empty()) return 0;
  const double last = static_cast<double>(distances.size() - 1);
  const auto at = static_cast<std::ptrdiff_t>(std::ceil(std::clamp(fraction, 0.0, 1.0) * last));
  std::nth_element(distances.begin(), distances.begin() + at, distances.end());
  return distances[static_cast<std::size_t>(at)];
}

}  // namespace t4d::measure
