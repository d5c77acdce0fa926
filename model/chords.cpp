#include "model/chords.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace t4d::model {

double Chords::forAngle(double radians) const {
  const double half = std::abs(radians) / 2;
  if (half > std::numbers::pi) return 2 * radius + edgeFactor * edge;
  // 1 - cos(half), without cancellation at small angles.
  const double sine = std::sin(half / 2);
  return 2 * radius * sine * sine + edgeFactor * edge * std::sin(half);
}

double Chords::angleFor(double length) const {
  if (forAngle(std::numbers::pi) <= length) return std::numbers::pi;
  // With t = tan(theta/4): (2 r - length) t^2 + 2 k e t - length = 0.
  const double twist = edgeFactor * edge;
  const double root = std::sqrt(std::max(0.0, twist * twist + length * (2 * radius - length)));
  return std::min(std::numbers::pi, 4 * std::atan(length / (twist + root)));
}

double edgeDeviation(std::span<const Point3> from, std::span<const Point3> to,
                     std::span<const Triangle> triangles, double edgeFactor) {
  double largest = 0;
  for (const Triangle& triangle : triangles) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t i = triangle[k];
      const std::uint32_t j = triangle[(k + 1) % 3];
      const Point3 change = (to[j] - from[j]) - (to[i] - from[i]);
      largest = std::max(largest, change.squaredNorm());
    }
  }
  return edgeFactor / 2 * std::sqrt(largest);
}

}  // namespace t4d::model
