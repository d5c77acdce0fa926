#include "tools/t4d/surface_agreement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "measure/surface_samples.h"
#include "measure/triangle_tree.h"

namespace t4d::tools {
namespace {

/// The distances of points of one surface from the other, increasing.
std::vector<double> distancesFrom(const model::TriangleMesh& of, const model::TriangleMesh& from) {
  const measure::TriangleTree tree(from);
  std::vector<double> distances;
  distances.reserve(measure::kSurfaceSamples);
  for (const measure::SurfaceSample& sample :
       measure::surfaceSamples(of, measure::kSurfaceSamples)) {
    distances.push_back(tree.nearest(sample.place).distance);
  }
  std::ranges::sort(distances);
  return distances;
}

double meanOf(const std::vector<double>& numbers) {
  if (numbers.empty()) return 0;
  return std::accumulate(numbers.begin(), numbers.end(), 0.0) / static_cast<double>(numbers.size());
}

}  // namespace

SurfaceAgreement surfaceAgreement(const model::TriangleMesh& a, const model::TriangleMesh& b) {
  if (a.triangles.empty() && b.triangles.empty()) return {};
  if (a.triangles.empty() || b.triangles.empty()) {
    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    return {kInfinite, kInfinite};
  }
  constexpr double kPart = 0.95;
  SurfaceAgreement agreement;
  double total = 0;
  for (const auto& [of, from] : {std::pair{&a, &b}, std::pair{&b, &a}}) {
    const std::vector<double> distances = distancesFrom(*of, *from);
    const double area = surfaceArea(*of);
    total += area;
    agreement.meanDistance += area * meanOf(distances);
    if (distances.empty()) continue;
    const double last = static_cast<double>(distances.size() - 1);
    agreement.hausdorff95 = std::max(agreement.hausdorff95,
                                     distances[static_cast<std::size_t>(std::ceil(kPart * last))]);
  }
  if (total > 0) agreement.meanDistance /= total;
  return agreement;
}

}  // namespace t4d::tools
