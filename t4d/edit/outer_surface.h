#pragma once

#include <cstdint>

#include "t4d/edit/surface_crossings.h"
#include "t4d/model/error.h"
#include "t4d/model/triangle_mesh.h"

namespace t4d::edit {

struct OuterSurface {
  model::TriangleMesh mesh;
  std::uint64_t cut = 0;      ///< triangles that others cut
  std::uint64_t dropped = 0;  ///< pieces of triangles with solid, or none, on both sides
};

/// The boundary of where the winding number of a surface is 1 or more: where solids overlap it is
/// that of their union, and where a surface turns inside out, what is inside out is gone.
///
/// Triangles are cut where they meet, in exact arithmetic (coplanar ones together), so that the
/// pieces form patches with one winding number on each side; then the patches between a side with
/// less than 1 and one with 1 or more are kept (Zhou, Grinspun, Zorin and Jacobson 2016). Vertices
/// with equal places are one. Coordinates of new vertices are rounded, which can make new
/// crossings, smaller by some 15 digits: check, and call it again.
///
/// `mesh` must be closed (model::isClosed), but may have edges with more than two triangles;
/// `crossings` are all of its own. Fails if a winding number cannot be told, and in a build without
/// CGAL.
Result<OuterSurface> outerSurface(const model::TriangleMesh& mesh,
                                  const SurfaceCrossings& crossings);

}  // namespace t4d::edit
