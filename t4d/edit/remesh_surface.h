#pragma once

#include "t4d/model/error.h"
#include "t4d/model/slab.h"
#include "t4d/model/triangle_mesh.h"

namespace t4d::edit {

/// The maximum number of lattice cells that the surface of `remeshSurface` may pass through; each
/// takes some 500 bytes.
inline constexpr double kMostRemeshedCells = 1e7;

/// A closed surface about what a heap of triangles encloses, whatever its faults: the boundary of
/// where its generalised winding number is more than 1/2. Holes are closed, as far as they are seen
/// from inside as less than half of the sphere; what overlaps becomes one.
///
/// The winding number is computed at the points of a lattice of step `voxelSize`, only near the
/// surface; the lattice's cubes are cut into six tetrahedra, and the surface passes between points
/// inside and outside, where the distances from the triangles are in balance. It is a manifold,
/// does not cross itself and faces outward. It is within `voxelSize` times the root of 3 of the
/// triangles where they separate inside from outside; edges are rounded off, and parts thinner than
/// the voxel size are lost.
///
/// Fails if the voxels are too small, or too large for anything to be inside.
Result<model::TriangleMesh> remeshSurface(const model::TriangleMesh& mesh, double voxelSize,
                                          const model::Progress& progress = {});

}  // namespace t4d::edit
