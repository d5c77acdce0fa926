#pragma once

#include <cstddef>
#include <vector>

#include "t4d/surface.h"

namespace t4d::measure {

/// A point of a surface.
struct SurfaceSample {
  model::Point3 place;
  model::Point3 normal;  ///< outward, of length 1
};

/// The number of samples where a mean or a quantile over a surface is asked for.
inline constexpr std::size_t kSurfaceSamples = 10'000;

/// `count` points spread evenly over the area of a surface, the same ones every time; none if it
/// has no area.
std::vector<SurfaceSample> surfaceSamples(const model::TriangleMesh& mesh, std::size_t count);

}  // namespace t4d::measure
