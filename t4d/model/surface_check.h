#pragma once

#include "t4d/model/error.h"
#include "t4d/model/triangle_mesh.h"

namespace t4d::model {

/// Says why `mesh` does not bound a solid, and where; the first failure, from fast checks to slow:
/// no triangles, an index out of range, a coordinate that is not finite, a triangle with a corner
/// twice, an edge with one triangle (an open mesh) or more than two (not a manifold), two triangles
/// that walk their edge the same way (inconsistent orientation), a vertex where several fans of
/// triangles touch (not a manifold). Self-intersection is not looked for.
///
/// Counts of all boundary edges are in the message, so that a reader sees how far from closed it
/// is.
Result<void> checkClosedSurface(const TriangleMesh& mesh);

}  // namespace t4d::model
