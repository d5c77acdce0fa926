#include "voxel4d/point_field.h"

#include <memory>
#include <span>

#include "voxel4d/field_metadata.h"
#include "voxel4d/vdb_grid.h"
#include "voxel4d/vdb_series.h"
#include "voxel4d/vdb_voxel.h"

namespace t4d::voxel4d {
namespace {

model::Part partOf(const PointField& field) {
  return field.part ? field.part->part : model::Part();
}

void addMetadata(const PointField& field, openvdb::MetaMap& metadata) {
  const auto& [part, run] = *field.part;
  const auto add = [&](const char* name, std::uint64_t number) {
    metadata.insertMeta(name, openvdb::Int64Metadata(static_cast<std::int64_t>(number)));
  };
  add(kPartNumber, part.number);
  add(kPartCount, part.count);
  for (int axis = 0; axis < 3; ++axis) add(kPartPoints[axis], field.counts[axis]);
  for (const auto& [name, value] : run) {
    metadata.insertMeta(kPartRun + name, openvdb::StringMetadata(value));
  }
}

template <class Grid>
openvdb::GridBase::Ptr gridOf(const PointField& field) {
  using Leaf = typename Grid::TreeType::LeafNodeType;
  using Value = typename Grid::ValueType;
  auto grid = Grid::create(Value(0));
  grid->setName(field.name);
  grid->setTransform(transformOf(field.lattice));
  if (field.part) addMetadata(field, *grid);
  std::unique_ptr<Leaf> leaf;
  const auto blocks = [&](int axis) { return (field.counts[axis] + 7) / 8; };
  const model::PartRange own = partOf(field).of(blocks(0));
  for (auto x = static_cast<std::uint32_t>(own.begin); x < own.end; ++x) {
    for (std::uint32_t y = 0; y < blocks(1); ++y) {
      for (std::uint32_t z = 0; z < blocks(2); ++z) {
        for (std::uint32_t i = 0; i < 512; ++i) {
          const std::array<std::uint32_t, 3> at = {8 * x + i / 64, 8 * y + i / 8 % 8,
                                                   8 * z + i % 8};
          double value = 0;
          if (at[0] >= field.counts[0] || at[1] >= field.counts[1] || at[2] >= field.counts[2] ||
              !field.value(at, value)) {
            continue;
          }
          if (!leaf) {
            leaf = std::make_unique<Leaf>(openvdb::Coord(int(8 * x), int(8 * y), int(8 * z)),
                                          Value(0));
          }
          leaf->setValueOn(i, static_cast<Value>(value));
        }
        if (leaf) grid->tree().addLeaf(leaf.release());
      }
    }
  }
  return grid;
}

}  // namespace

Result<std::uint64_t> writePointField(const std::filesystem::path& path, const PointField& field) {
  if (auto good = checkVdbVoxel(field.lattice.voxelSize); !good) return good.error();
  initializeOpenVdb();
  return writeVdb(
      path, field.whole ? gridOf<openvdb::Int32Grid>(field) : gridOf<openvdb::FloatGrid>(field));
}

}  // namespace t4d::voxel4d
