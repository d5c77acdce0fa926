#include "voxel4d/vdb_samples.h"

#include <sstream>

#include <fmt/format.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>

#include "t4d/frames.h"
#include "voxel4d/vdb_grid.h"

namespace t4d::voxel4d {

namespace {

/// Writes files with offsets to memory, which io::Stream cannot do.
struct Archive : private openvdb::io::Archive {
  static std::string bytesOf(const openvdb::GridCPtrVec& grids, std::uint32_t compression,
                             bool offsets) {
    Archive archive;
    archive.setCompression(compression);
    std::ostringstream out(std::ios::binary);
    archive.write(out, grids, offsets);
    return out.str();
  }
};

/// Sets the voxels of a leaf node so that it has `inactive` kinds of inactive values.
template <class Grid>
typename Grid::Ptr gridWith(int inactive) {
  using Value = typename Grid::ValueType;
  auto grid = Grid::create(Value(3));
  grid->insertMeta(kTimeMetadata, openvdb::DoubleMetadata(1));
  grid->setName("solid");
  for (int i = 0; i < 8; ++i) {
    grid->tree().setValueOn({i, 1, 2}, Value(i - 3.5));
    // The background, its negative, one other value, both, all different.
    const Value off[] = {Value(3), Value(-3), Value(1), Value(i % 2 == 0 ? 3 : 1), Value(i + 1)};
    if (inactive > 0) grid->tree().setValueOff({i, 2, 2}, off[inactive]);
  }
  grid->tree().addTile(1, {16, 0, 0}, Value(-3), false);
  return grid;
}

openvdb::BoolGrid::Ptr bools() {
  auto grid = openvdb::BoolGrid::create(false);
  grid->setName("inside");
  grid->tree().setValueOn({1, 2, 3}, true);
  grid->tree().setValueOff({1, 2, 4}, true);
  grid->tree().setValueOn({9, 2, 5}, false);
  grid->tree().addTile(2, {200, 0, 0}, true, true);
  return grid;
}

openvdb::MaskGrid::Ptr mask() {
  auto grid = openvdb::MaskGrid::create();
  grid->setName("inside");
  grid->tree().setValueOn({1, 2, 3});
  grid->tree().addTile(3, {5000, 0, 0}, true, true);
  return grid;
}

openvdb::Vec3SGrid::Ptr velocities(openvdb::GridClass kind) {
  auto grid = openvdb::Vec3SGrid::create(openvdb::Vec3f(0, 0, 1));
  grid->setName("v");
  grid->setGridClass(kind);
  for (int i = 0; i < 8; ++i) {
    grid->tree().setValueOn({i, 1, 2}, openvdb::Vec3f(0.5F * static_cast<float>(i), 1, 0));
    grid->tree().setValueOff({i, 2, 2}, openvdb::Vec3f(0, 0, -1));
  }
  grid->tree().addTile(1, {16, 0, 0}, openvdb::Vec3f(1, 2, 3), true);
  return grid;
}

template <class Grid>
typename Grid::Ptr halved(typename Grid::Ptr grid) {
  grid->setSaveFloatAsHalf(true);
  return grid;
}

}  // namespace

std::vector<VdbSample> vdbSamples() {
  initializeOpenVdb();
  using openvdb::DoubleGrid;
  using openvdb::FloatGrid;
  namespace io = openvdb::io;
  constexpr std::uint32_t kUsual = io::COMPRESS_BLOSC | io::COMPRESS_ACTIVE_MASK;
  std::vector<VdbSample> samples;
  const auto add = [&](std::string name, const openvdb::GridCPtrVec& grids,
                       std::uint32_t compression, bool offsets = true) {
    samples.push_back({std::move(name), Archive::bytesOf(grids, compression, offsets)});
  };
  for (int inactive = 0; inactive < 5; ++inactive) {
    add(fmt::format("inactive_{}", inactive), {gridWith<FloatGrid>(inactive)}, kUsual);
  }
  for (const std::uint32_t compression :
       {std::uint32_t{io::COMPRESS_NONE}, std::uint32_t{io::COMPRESS_ZIP},
        std::uint32_t{io::COMPRESS_BLOSC}, std::uint32_t{io::COMPRESS_ACTIVE_MASK},
        std::uint32_t{io::COMPRESS_ZIP | io::COMPRESS_ACTIVE_MASK}}) {
    // Uncompressed, a node of tiles alone takes 128 KiB.
    if ((compression & ~std::uint32_t{io::COMPRESS_ACTIVE_MASK}) != 0) {
      add(fmt::format("float_{}", compression), {gridWith<FloatGrid>(3)}, compression);
      add(fmt::format("half_{}", compression), {halved<DoubleGrid>(gridWith<DoubleGrid>(2))},
          compression);
    }
    add(fmt::format("bool_{}", compression), {bools()}, compression);
  }
  add("int32", {gridWith<openvdb::Int32Grid>(3)}, kUsual);
  add("double", {gridWith<DoubleGrid>(4)}, kUsual);
  add("float_mask_only", {gridWith<FloatGrid>(1)}, io::COMPRESS_ACTIVE_MASK);
  add("half", {halved<FloatGrid>(gridWith<FloatGrid>(3))}, kUsual);
  add("mask", {mask()}, kUsual);
  add("streamed", {gridWith<FloatGrid>(3), bools()}, kUsual, false);
  add("velocity", {gridWith<FloatGrid>(1), velocities(openvdb::GRID_STAGGERED)}, kUsual);
  add("velocity_half", {halved<openvdb::Vec3SGrid>(velocities(openvdb::GRID_UNKNOWN))}, kUsual,
      false);
  const auto shared = gridWith<FloatGrid>(1);
  const auto twin = shared->copy();
  twin->insertMeta(kTimeMetadata, openvdb::DoubleMetadata(2));
  add("shared", {shared, twin}, kUsual);
  return samples;
}

}  // namespace t4d::voxel4d
