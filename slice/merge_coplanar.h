#pragma once

#include <cstdint>

#include "t4d/surface.h"

namespace t4d::slice {

struct CoplanarMerge {
  std::uint64_t trianglesBefore = 0;
  /// Points this close to a plane count as on it: the rounding of a slice.
  double tolerance = 0;
  /// A bound on the Hausdorff distance between the surfaces before and after: the largest distance
  /// of a vertex from the plane of its region, at most `tolerance`.
  double distance = 0;
};

/// Divides the planar parts of a surface into fewer triangles. A part is a connected set of
/// triangles on one plane. Vertices are left out, and none is moved or added: those inside a part,
/// and those on a straight line between two. So a closed surface remains closed, and encloses the
/// same volume up to rounding.
///
/// A vertex is left out by moving it along an edge to the next one (a half-edge collapse), if all
/// its triangles keep their orientation and no others become neighbours. Where collapses block each
/// other, more vertices remain than necessary. Vertices at edges that do not have two triangles
/// remain.
///
/// With `keepAttributes`, all triangles of a part have equal cell attributes; otherwise cell
/// attributes are dropped. Vertices keep their attributes.
CoplanarMerge mergeCoplanar(model::TriangleMesh& mesh, bool keepAttributes);

}  // namespace t4d::slice
