#pragma once

#include "t4d/error.h"
#include "t4d/mesh.h"
#include "t4d/surface.h"

namespace t4d::edit {

/// The maximum number of lattice cells that the surface of `remeshSurface` may pass through; each
/// takes some 500 bytes.
inline constexpr double kMostRemeshedCells = 1e7;

/// A closed surface around the region that triangles enclose, whatever their faults: the boundary
/// of the region where their generalised winding number is above 1/2. A hole is closed if it covers
/// less than half of the sphere, seen from inside. Overlapping parts are united.
///
/// The winding number is computed at the points of a lattice of step `voxelSize`, only near the
/// surface. The lattice's cubes are cut into six tetrahedra. The surface passes between points
/// inside and outside, in proportion to their distances from the triangles. It is a manifold, does
/// not cross itself and faces outward. It is within sqrt(3) `voxelSize` of the triangles that
/// separate inside from outside; edges are rounded off, and parts thinner than the voxel size are
/// lost.
///
/// Fails if the voxels are too small, or too large for anything to be inside.
Result<model::TriangleMesh> remeshSurface(const model::TriangleMesh& mesh, double voxelSize,
                                          const model::Progress& progress = {});

}  // namespace t4d::edit
