#pragma once

#include <memory>

#include "t4d/edit/mend_surface.h"
#include "t4d/model/vertex_keys.h"

namespace t4d::edit {

/// Mends a surface that is deformed, without moving anything: steps 1 to 5 of mendSurface at the
/// first key, whose positions `mesh` gets. All keys have the resulting triangles; merged vertices
/// have the positions of the first of them. `keys` are replaced by those of the mended surface.
///
/// On failure nothing is changed. Fails if triangles cross or touch at the first key, since taking
/// the outer surface moves vertices; if vertices within `weld` of each other at the first key are
/// farther apart at another (checked when that key is read); if a hole is wider at the first key
/// than `maxHole`; and if mendSurface does. `maxMove` and `remesh` are not used. The Hausdorff
/// distance and the volumes are those at the first key. A build without CGAL has the restrictions
/// of mendSurface.
Result<MendSurfaceReport> mendDeformation(model::TriangleMesh& mesh,
                                          std::unique_ptr<model::VertexKeys>& keys,
                                          const MendSurfaceOptions& options = {});

}  // namespace t4d::edit
