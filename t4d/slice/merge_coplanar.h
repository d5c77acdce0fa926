#pragma once

#include <cstdint>

#include "t4d/model/triangle_mesh.h"

namespace t4d::slice {

struct CoplanarMerge {
  std::uint64_t trianglesBefore = 0;
  /// Points this close to a plane are taken to be on it: what rounding does to a slice.
  double tolerance = 0;
  /// No point of the surface is further than this from the one before, nor the other way round: the
  /// largest distance of a vertex from the plane of its region, at most `tolerance`.
  double distance = 0;
};

/// Divides the planar parts of a surface into fewer triangles. A part is a connected set of
/// triangles on one plane. Vertices are left out, and none is moved or added: those inside a part,
/// and those on a straight line between two. So a closed surface remains closed, and encloses the
/// same volume but for rounding.
///
/// A vertex is left out by moving it along an edge to the next one (a half-edge collapse), if all
/// its triangles keep their orientation and no others become neighbours. Where that blocks itself,
/// more vertices remain than necessary. Vertices at edges that do not have two triangles remain.
///
/// With `keepAttributes`, triangles of a part have equal attributes of cells; else these are
/// dropped. Attributes of vertices remain those of the vertices.
CoplanarMerge mergeCoplanar(model::TriangleMesh& mesh, bool keepAttributes);

}  // namespace t4d::slice
