#pragma once

#include "t4d/error.h"
#include "t4d/surface.h"

namespace t4d::model {

/// Checks that `mesh` bounds a solid. The error is the first of these, with its location: no
/// triangles; a coordinate that is not finite; an index out of range; a triangle with a repeated
/// vertex; a boundary edge, with one triangle; a non-manifold edge, with more than two;
/// inconsistent orientation, two triangles with their common edge in the same direction; two
/// triangles with the same corners; a non-manifold vertex, where several fans of triangles touch.
/// Does not look for self-intersections.
///
/// The message gives the total number of edges of that kind, which shows how far from closed the
/// mesh is.
Result<void> checkClosedSurface(const TriangleMesh& mesh);

}  // namespace t4d::model
