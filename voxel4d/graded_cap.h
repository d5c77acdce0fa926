#pragma once

#include <cstdint>

#include "t4d/mesh.h"
#include "voxel4d/frame_layer.h"

namespace t4d::voxel4d {

/// The end of a 4D mesh that a cap closes.
enum class CapEnd : std::uint8_t { First, Last };

/// The cap that closes a mesh exactly at the time of its first or last frame, with cells that grow
/// inwards: their number is in proportion to the surface of the solid, not to its volume.
///
/// The lattice cubes whose corners are all inside are merged into the cubes of an octree, and a
/// large cube is a cone from its centre over its triangulated faces. A section:
///
///     o---o---o---o       Cubes at the surface, and those that cannot be merged, are divided as in
///     |  /|  /|  /|       a flat cap (pattern_table.h). So the triangles at the surface are those
///     o---o---o---o       of the weave, and every square is cut from its lowest corner.
///     |  /|\  |  /|
///     o---o   *   o       Every corner of a cube is a point of the mesh. A face with such a point
///     |  /| / | \ |       at its centre has smaller cubes on the other side and is divided into
///     o---o---o---o       four, and so on. What is left is cut from its lowest corner, or, if
///                         corners of other cubes lie on its edges, into a fan from its centre.
///
/// How a face is cut depends on the points alone, so both cubes at it cut it alike, whatever their
/// sizes. The vertices of the layer are those of `layer`, in its order; all others are lattice
/// points. Fails for more than 2^32 - 1 vertices or cells.
Result<model::Slab> gradedCap(const FrameLayer& layer, const Lattice& lattice, CapEnd end);

}  // namespace t4d::voxel4d
