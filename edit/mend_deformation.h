#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "t4d/edit.h"
#include "t4d/motion.h"

namespace t4d::edit {

/// The keys of a surface in time: more than one run where it jumps, or is not there for a while.
using Runs = std::vector<std::unique_ptr<model::VertexKeys>>;

/// Whether triangles may cross or touch at the first key, and components be nested: the ends of
/// such a surface can be closed by cones alone.
enum class Crossings : std::uint8_t { Refused, Accepted };

/// Mends a surface that is deformed, without moving anything: steps 1 to 5 of mendSurface at the
/// first key, whose positions `mesh` gets unless poses move it. All keys have the resulting
/// triangles, so that a hole that is filled stays so; merged vertices have the positions of the
/// first of them. What touches at vertices or edges gets vertices of its own at the same places,
/// and in the middle of these edges. With `thicken`, sheets get that thickness at each key, along
/// the normals of their vertices there. `runs` are replaced by those of the mended surface.
///
/// On failure nothing is changed. Fails for what `crossings` refuses (Remedy::ConeCapsAlone), since
/// taking the outer surface moves vertices; for sheets without `thicken` (Remedy::Thicken); if
/// vertices within `weld` of each other at the first key are farther apart at another (checked when
/// that key is read); if a hole is wider at the first key than `maxHole`; and if mendSurface does.
/// `maxMove` and `remesh` are not used. Attributes are carried along (carried_attributes.h). The
/// Hausdorff distance and the volumes are those at the first key. A build without CGAL has the
/// restrictions of mendSurface, and finds no sheets.
Result<MendSurfaceReport> mendDeformation(model::TriangleMesh& mesh, Runs& runs,
                                          const MendSurfaceOptions& options = {},
                                          Crossings crossings = Crossings::Refused);

}  // namespace t4d::edit
