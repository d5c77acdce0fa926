#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include <openvdb/tools/MeshToVolume.h>
#include <openvdb/tools/Prune.h>

#include "model/parallel.h"
#include "voxel4d/occupancy.h"
#include "voxel4d/vdb_grid.h"
#include "voxel4d/vdb_voxel.h"

namespace t4d::voxel4d {

using model::Point3;

namespace {

/// The surface of a solid in voxels, with the interface that OpenVDB expects.
struct IndexSpaceMesh {
  std::span<const Point3> points;
  std::span<const model::Triangle> triangles;
  Point3 origin;  // the point of the lattice that becomes 0

  std::size_t polygonCount() const { return triangles.size(); }
  std::size_t pointCount() const { return points.size(); }
  std::size_t vertexCount(std::size_t /*triangle*/) const { return 3; }
  void getIndexSpacePoint(std::size_t triangle, std::size_t corner, openvdb::Vec3d& point) const {
    const Point3 p = points[triangles[triangle][corner]] - origin;
    point = {p.x(), p.y(), p.z()};
  }
};

/// A lattice point near the surface, the corner of a leaf node, if it is far from point 0: OpenVDB
/// computes distances with float32 coordinates.
openvdb::Coord originNear(std::span<const Point3> points) {
  constexpr double kFar = 1 << 16;
  model::Bounds3 bounds;
  for (const Point3& point : points) bounds.add(point);
  openvdb::Coord origin(0);
  for (int axis = 0; axis < 3; ++axis) {
    const double middle = bounds.min[axis] / 2 + bounds.max[axis] / 2;
    if (std::abs(middle) > kFar) origin[axis] = static_cast<std::int32_t>(middle) / 8 * 8;
  }
  return origin;
}

/// A copy of a tree with its values multiplied by `scale` and its nodes moved by `shift`, a
/// multiple of 8. The tree must have values in leaf nodes only.
openvdb::FloatTree::Ptr movedTree(const openvdb::FloatTree& from, float scale,
                                  const openvdb::Coord& shift) {
  auto into = std::make_shared<openvdb::FloatTree>(scale * from.background());
  for (auto leaf = from.cbeginLeaf(); leaf; ++leaf) {
    auto* copy = into->touchLeaf(leaf->origin() + shift);
    copy->setValueMask(leaf->getValueMask());
    float* value = copy->buffer().data();
    for (unsigned i = 0; i < 512; ++i) value[i] = scale * leaf->getValue(i);
  }
  return into;
}

/// The distance from the surface near it, without a sign.
openvdb::FloatGrid::Ptr distancesFrom(const UnionSurface& surface, const Lattice& lattice) {
  // OpenVDB cannot compute with small voxels. Those are scaled by a power of two, which rounds
  // nothing.
  Lattice coarse = lattice;
  while (coarse.voxelSize < kFinestVoxel) coarse.voxelSize *= 2;
  coarse.origin.setZero();
  const openvdb::Coord origin = originNear(surface.points);
  auto grid = openvdb::tools::meshToVolume<openvdb::FloatGrid>(
      IndexSpaceMesh{surface.points,
                     surface.outer,
                     {double(origin.x()), double(origin.y()), double(origin.z())}},
      *transformOf(coarse), kHalfWidth, kHalfWidth, openvdb::tools::UNSIGNED_DISTANCE_FIELD);
  const auto scale = static_cast<float>(lattice.voxelSize / coarse.voxelSize);
  if (scale != 1 || origin != openvdb::Coord(0)) {
    grid->setTree(movedTree(grid->tree(), scale, origin));
  }
  grid->setTransform(transformOf(lattice));
  return grid;
}

}  // namespace

openvdb::FloatGrid::Ptr levelSetOf(const Occupancy& occupancy, const Lattice& lattice) {
  // OpenVDB tells inside from outside by flooding from outside, which fills cavities. So it
  // computes only the distances, and we set the signs.
  const Frame& inside = occupancy.inside;
  auto grid = distancesFrom(occupancy.surface, lattice);
  openvdb::FloatTree& tree = grid->tree();
  const float background = tree.background();

  std::vector<openvdb::FloatTree::LeafNodeType*> leaves;
  tree.getNodes(leaves);
  model::forEach(leaves.size(), [&](std::size_t i) {
    const BlockMask mask = insideOf(inside, blockAt(leaves[i]->origin()));
    float* value = leaves[i]->buffer().data();
    for (unsigned j = 0; j < 512; ++j) {
      // A distance may be zero by rounding; an inside point needs a sign.
      constexpr float kLeast = std::numeric_limits<float>::min();
      if ((mask[j / 64] >> (j % 64) & 1U) != 0) value[j] = -std::max(value[j], kLeast);
    }
  });
  for (const InsideTile& tile : inside.tiles) {
    const openvdb::Coord corner = cornerOf(tile.coord);
    if (tree.probeLeaf(corner) == nullptr) tree.addTile(1, corner, -background, false);
  }
  openvdb::tools::pruneTiles(tree);
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  return grid;
}

}  // namespace t4d::voxel4d
