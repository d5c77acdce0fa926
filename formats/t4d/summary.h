#pragma once

#include <cstdint>

#include "model/geometry.h"
#include "model/slab.h"

namespace t4d::formats {

/// Summary of one body in a .t4d file.
struct BodySummary {
  std::uint64_t slabs = 0;
  std::uint64_t vertices = 0;  ///< vertices on a seam counted once
  std::uint64_t tetrahedra = 0;
  model::TimeSpan time;
  model::Bounds3 bounds;  ///< of all vertices
};

}  // namespace t4d::formats
