#pragma once

#include <span>

#include "t4d/frames.h"
#include "t4d/surface.h"
#include "voxel4d/union_surface.h"

namespace t4d::voxel4d {

/// Lattice points closer to the surface than this fraction of the largest coordinate (in voxels)
/// count as on it. This is several thousand roundings of a double, more than posing a mesh
/// accumulates.
inline constexpr double kOnSurface = 1e-12;

/// Lattice coordinates range from -kMaxCoordinate to kMaxCoordinate, so that sums of them fit.
inline constexpr std::int32_t kMaxCoordinate = 1 << 28;

/// The maximum number of points in the box around a solid: 4096 along each axis.
inline constexpr double kMaxBoxPoints = 68'719'476'736.0;

/// Fails for a mesh that does not bound a solid (an edge that is not traversed equally often in
/// both directions, an index out of range, a coordinate that is not finite), and for one with too
/// many lattice points in its box or too far from the origin; the error says how many or how far.
Result<void> checkVoxelizable(const model::TriangleMesh& mesh, const Lattice& lattice);

/// The points inside a mesh on a lattice.
struct Occupancy {
  Frame inside;
  UnionSurface surface;  ///< in voxels
};

/// The lattice points strictly inside the union of all that `mesh` encloses. A point away from the
/// surface is inside if its winding number is not zero. A point on the surface (see kOnSurface) is
/// outside, unless the surface about it lies within the union, such as the faces along which solids
/// overlap or touch. Self-intersections, cavities, several components and triangles without area
/// are allowed; the empty mesh has nothing inside.
///
/// For every lattice column along z, the triangles that it crosses are sorted and their windings
/// summed. Which triangles a column crosses is decided in exact arithmetic, for the column shifted
/// by (e, e^2) with e infinitesimal, so a column through an edge or a vertex crosses the right
/// number of triangles.
///
/// The frame has no values; every tile is one block.
Result<Occupancy> occupancyOf(const model::TriangleMesh& mesh, const Lattice& lattice, double time);

/// The frame of occupancyOf.
Result<Frame> occupancy(const model::TriangleMesh& mesh, const Lattice& lattice, double time);

/// The inside points of one block of `frame`, found by binary search.
BlockMask insideOf(const Frame& frame, const Coord& block);

}  // namespace t4d::voxel4d
