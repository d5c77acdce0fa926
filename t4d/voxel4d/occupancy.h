#pragma once

#include <span>

#include "t4d/model/triangle_mesh.h"
#include "t4d/voxel4d/frame.h"

namespace t4d::voxel4d {

/// Lattice points nearer to the surface than this part of the largest coordinate (in voxels) lie on
/// it: some thousand roundings of a double, more than posing a mesh adds up.
inline constexpr double kOnSurface = 1e-12;

/// Lattice coordinates go from -kMaxCoordinate to kMaxCoordinate, so that sums of them fit.
inline constexpr std::int32_t kMaxCoordinate = 1 << 28;

/// More points than this in the box around a solid are refused: 4096 along each axis.
inline constexpr double kMaxBoxPoints = 68'719'476'736.0;

/// Refuses a mesh that bounds no solid (an edge that is not walked as often in one direction as in
/// the other, an index out of range, a coordinate that is not finite), and one with more lattice
/// points in its box, or further away, than allowed; the error says how many there would be.
Result<void> checkVoxelizable(const model::TriangleMesh& mesh, const Lattice& lattice);

/// The lattice points strictly inside `mesh`: those that its surface winds around. A point on the
/// surface (see kOnSurface) is outside. Self-intersections, cavities, several components and
/// triangles without area are all right; the empty mesh has nothing inside.
///
/// Along every lattice column in direction z the crossed triangles are sorted, and their windings
/// summed. Which triangles a column crosses is decided in exact arithmetic, for the column shifted
/// by (e, e^2) with e infinitely small; so one that meets an edge or a vertex crosses as many
/// triangles as it should.
///
/// The frame has no values; all tiles are of one block.
Result<Frame> occupancy(const model::TriangleMesh& mesh, const Lattice& lattice, double time);

/// The inside points of one block of `frame`, found by binary search.
BlockMask insideOf(const Frame& frame, const Coord& block);

}  // namespace t4d::voxel4d
