#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "t4d/error.h"
#include "t4d/mesh.h"
#include "t4d/surface.h"
#include "t4d/sweep.h"

namespace t4d::mesh4d {

/// A solid filled with tetrahedra, which closes the 4D mesh at its first or last time.
struct Cap {
  /// Points added inside the solid, in the coordinates of the mesh; none on the surface.
  std::vector<model::Point3> inner;
  /// Indices into the vertices of the mesh followed by `inner`; det[b-a, c-a, d-a] > 0.
  std::vector<model::Cell> cells;
};

/// Fills the solid that `mesh` bounds (closed and facing outward; may have cavities and several
/// components). With TetGen it fails if triangles intersect or have no area (the error names them),
/// or if a component faces the wrong way.
Result<Cap> fillSolid(const model::TriangleMesh& mesh, CapMethod method);

/// The cap of a mesh as a slab without thickness. At the start, the mesh is the upper layer of the
/// slab, and the cap faces backward in time. At the end, the mesh is the lower layer, and the cap
/// faces forward. Cells have the same attributes as those of steps.
std::shared_ptr<const model::Connectivity> startCapConnectivity(const Cap& cap,
                                                                const model::TriangleMesh& mesh);
std::shared_ptr<const model::Connectivity> endCapConnectivity(const Cap& cap,
                                                              const model::TriangleMesh& mesh);

/// Fails if triangles intersect or have no area; the error names them.
Result<void> checkNoSelfIntersection(const model::TriangleMesh& mesh);

}  // namespace t4d::mesh4d
