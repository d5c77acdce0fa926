#pragma once

#include <cstdint>

#include "edit/surface_crossings.h"
#include "t4d/error.h"
#include "t4d/surface.h"

namespace t4d::edit {

struct OuterSurface {
  model::TriangleMesh mesh;
  std::uint64_t cut = 0;      ///< triangles that others cut
  std::uint64_t dropped = 0;  ///< pieces of triangles inside the result, or outside
};

/// The boundary of the region where the winding number of a surface is 1 or more. Overlapping
/// solids become their union; parts that are inside out are removed.
///
/// Triangles are cut where they meet, in exact arithmetic (coplanar ones together), so that the
/// pieces form patches with one winding number on each side; then the patches with less than 1 on
/// one side and 1 or more on the other are kept (Zhou, Grinspun, Zorin and Jacobson 2016). Vertices
/// at equal positions are merged. Coordinates of new vertices are rounded, which can cause new
/// crossings, smaller by some 15 digits: check the result, and call this function again.
///
/// `mesh` must be closed (model::isClosed), but may have edges with more than two triangles;
/// `crossings` are all its crossings. Fails if a winding number cannot be determined, and in a
/// build without CGAL.
Result<OuterSurface> outerSurface(const model::TriangleMesh& mesh,
                                  const SurfaceCrossings& crossings);

}  // namespace t4d::edit
