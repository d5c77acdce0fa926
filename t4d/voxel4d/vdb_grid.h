#pragma once

#include <optional>
#include <string>

#include <openvdb/openvdb.h>

#include "t4d/model/triangle_mesh.h"
#include "t4d/voxel4d/frame.h"

/// Between grids of OpenVDB and frames. For the sources of this folder alone: no header that others
/// include has OpenVDB in it.
namespace t4d::voxel4d {

/// Makes OpenVDB's types known; to be called before anything of it is used, any number of times.
void initializeOpenVdb();

/// The block that a point lies in, and the first point of a block.
Coord blockAt(const openvdb::Coord& point);
openvdb::Coord cornerOf(const Coord& block);

openvdb::math::Transform::Ptr transformOf(const Lattice& lattice);

/// "float", "mask", ... (OpenVDB calls the values of a mask grid bool).
std::string typeOf(const openvdb::GridBase& grid);

enum class GridKind : std::uint8_t { Values, Mask };

/// Whether the grid has values (float, double) or only insides (bool, mask); others are refused by
/// their type.
Result<GridKind> kindOf(const openvdb::GridBase& grid, const std::string& where);

/// Refuses all transforms but a uniform scale with a translation; says what was found.
Result<Lattice> latticeOf(const openvdb::GridBase& grid, const std::string& where);

/// The frame of a grid, which becomes its owner: leaf nodes are blocks, inside values above them
/// tiles. Without `iso` values below zero are inside, with it values above; of bool grids the true
/// values; of mask grids the active points. Refused: a background that is inside, values that are
/// not finite, points further than kMaxCoordinate from the origin.
Result<Frame> frameOf(const openvdb::GridBase::ConstPtr& grid, double time,
                      const std::optional<double>& iso, const std::string& where);

/// The inside of a frame as a bool grid: its points are true and active.
openvdb::BoolGrid::Ptr boolGridOf(const Frame& frame, const Lattice& lattice);

/// Half the width of the narrow band, in voxels.
inline constexpr float kHalfWidth = 3;

/// The signed distance from a solid as a level set with a narrow band of kHalfWidth voxels on
/// either side. `inside` is occupancy(mesh, lattice): it has the sign, so cavities and
/// self-intersections are what they are there.
openvdb::FloatGrid::Ptr levelSetOf(const model::TriangleMesh& mesh, const Lattice& lattice,
                                   const Frame& inside);

}  // namespace t4d::voxel4d
