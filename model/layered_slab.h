#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "t4d/mesh.h"

namespace t4d::model {

/// A slab whose means are not computed, for callers that need few of them. It has no vertex
/// attributes.
struct LayeredSlab {
  using Layer = std::shared_ptr<const std::vector<Point4>>;

  TimeSpan time;
  std::shared_ptr<const Connectivity> connectivity;
  Layer lower;
  std::vector<Point4> interior;  ///< without means
  Layer upper;
  std::vector<Attribute> cellAttributes;  ///< of this slab alone

  /// Vertex `number` of the slab. Means are computed like those of setMeans.
  Point4 vertex(std::uint32_t number) const {
    const Connectivity& counts = *connectivity;
    if (number < counts.lowerCount) return (*lower)[number];
    if (number >= counts.firstUpper()) return (*upper)[number - counts.firstUpper()];
    if (number < counts.firstMean()) return interior[number - counts.lowerCount];
    const std::uint32_t mean = number - counts.firstMean();
    const std::uint32_t begin = counts.means.offsets[mean];
    const std::uint32_t end = counts.means.offsets[mean + 1];
    Point4 sum = vertex(counts.means.sources[begin]);
    for (std::uint32_t k = begin + 1; k < end; ++k) sum += vertex(counts.means.sources[k]);
    return sum / static_cast<double>(end - begin);
  }
};

}  // namespace t4d::model
