#pragma once

#include <memory>

#include "t4d/edit/mend_surface.h"
#include "t4d/model/vertex_keys.h"

namespace t4d::edit {

/// Mends a surface that is deformed, without moving anything: steps 1 to 5 of mendSurface at the
/// first key, whose places `mesh` gets. The same triangles serve at all keys; vertices that were
/// merged have the places of the first of them. `keys` become those of the mended surface.
///
/// Fails, and then changes nothing, if triangles cross or touch at the first key, since taking the
/// outer surface moves vertices; if vertices within `weld` of each other at the first key are
/// farther apart at another (checked when that key is read); if a hole is wider at the first key
/// than `maxHole`; and as mendSurface. `maxMove` and `remesh` are not used. The Hausdorff distance
/// and the volumes are those at the first key. Without CGAL as mendSurface.
Result<MendSurfaceReport> mendDeformation(model::TriangleMesh& mesh,
                                          std::unique_ptr<model::VertexKeys>& keys,
                                          const MendSurfaceOptions& options = {});

}  // namespace t4d::edit
