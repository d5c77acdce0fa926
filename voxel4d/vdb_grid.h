#pragma once

#include <optional>
#include <string>

#include <openvdb/openvdb.h>

#include "t4d/frames.h"
#include "t4d/surface.h"
#include "voxel4d/occupancy.h"

/// Conversion between OpenVDB grids and frames. For the sources of this folder only: public headers
/// do not include OpenVDB.
namespace t4d::voxel4d {

/// Registers OpenVDB's types. Call it before using OpenVDB; repeated calls are harmless.
void initializeOpenVdb();

/// The block that a point lies in, and the first point of a block.
Coord blockAt(const openvdb::Coord& point);
openvdb::Coord cornerOf(const Coord& block);

/// The transform with this map, as read from a file. Transform's constructor would look for a
/// simpler map, which fails for small voxels.
openvdb::math::Transform::Ptr transformBy(const openvdb::math::MapBase& map);

/// The transform of a lattice. Below kFinestVoxel it has voxels of 1, and is not written.
openvdb::math::Transform::Ptr transformOf(const Lattice& lattice);

/// "float", "mask", ... (OpenVDB calls the values of a mask grid bool).
std::string typeOf(const openvdb::GridBase& grid);

enum class GridKind : std::uint8_t { Values, Mask };

/// Whether the grid has values (float, double) or only an inside (bool, mask). Fails for other
/// types.
Result<GridKind> kindOf(const openvdb::GridBase& grid, const Place& where);

/// Fails for all transforms except a uniform scale with a translation; the error says what was
/// found.
Result<Lattice> latticeOf(const openvdb::GridBase& grid, const Place& where);

/// A grid, and the values of its leaf nodes if its tree has none (VdbTree).
struct VdbGrid {
  openvdb::GridBase::Ptr grid;
  std::shared_ptr<const FrameFile> values;
};

/// The frame of a grid, which the frame then owns. Leaf nodes become blocks; inside values above
/// them become tiles. Inside are values below zero, or above `iso` if it is given, or `below` it;
/// true values of bool grids; and active points of mask grids. Fails for a background that is
/// inside, values that are not finite, and points farther than kMaxCoordinate from the origin.
Result<Frame> frameOf(const VdbGrid& grid, double time, const std::optional<double>& iso,
                      const Place& where, bool below = false);

/// The inside points of a frame as a bool grid: they are true and active.
openvdb::BoolGrid::Ptr boolGridOf(const Frame& frame, const Lattice& lattice);

/// Half the width of the narrow band, in voxels.
inline constexpr float kHalfWidth = 3;

/// The signed distance from a solid as a level set with a narrow band of kHalfWidth voxels on
/// either side. Its inside points are those of `occupancy`, and its distances are from the surface
/// that bounds them, whatever other parts of the mesh lie within the solid.
openvdb::FloatGrid::Ptr levelSetOf(const Occupancy& occupancy, const Lattice& lattice);

}  // namespace t4d::voxel4d
