#include "voxel4d/vdb_file.h"

#include <cstring>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <openvdb/io/Stream.h>

#include "platform/test_folder.h"
#include "voxel4d/vdb_samples.h"

namespace t4d::voxel4d {
namespace {

/// Expects both trees to have the same nodes and values, active and inactive.
template <class Tree>
void expectSameTree(const Tree& a, const Tree& b) {
  ASSERT_TRUE(a.hasSameTopology(b));
  EXPECT_EQ(a.background(), b.background());
  auto one = a.cbeginValueAll();
  auto other = b.cbeginValueAll();
  for (; one && other; ++one, ++other) {
    ASSERT_EQ(one.getBoundingBox(), other.getBoundingBox());
    ASSERT_EQ(*one, *other) << one.getCoord();
    ASSERT_EQ(one.isValueOn(), other.isValueOn()) << one.getCoord();
  }
  EXPECT_EQ(bool(one), bool(other));
}

void expectSameGrid(const openvdb::GridBase& a, const openvdb::GridBase& b) {
  ASSERT_EQ(a.type(), b.type());
  EXPECT_EQ(a.getName(), b.getName());
  EXPECT_EQ(a.transform(), b.transform());
  const auto compare = [&]<class Tree>(const Tree* tree) {
    if (tree != nullptr) expectSameTree(*tree, dynamic_cast<const Tree&>(b.constBaseTree()));
  };
  compare(dynamic_cast<const openvdb::FloatTree*>(&a.constBaseTree()));
  compare(dynamic_cast<const openvdb::DoubleTree*>(&a.constBaseTree()));
  compare(dynamic_cast<const openvdb::Int32Tree*>(&a.constBaseTree()));
  compare(dynamic_cast<const openvdb::BoolTree*>(&a.constBaseTree()));
  compare(dynamic_cast<const openvdb::MaskTree*>(&a.constBaseTree()));
  compare(dynamic_cast<const openvdb::Vec3STree*>(&a.constBaseTree()));
}

TEST(VdbFile, ReadsWhatOpenVdbReads) {
  const platform::TestFolder folder;
  for (const auto& [name, bytes] : vdbSamples()) {
    SCOPED_TRACE(name);
    const auto path = folder / (name + ".vdb");
    std::ofstream(path, std::ios::binary) << bytes;
    auto file = VdbFile::open(path);
    ASSERT_TRUE(file) << file.error().text();
    std::istringstream in(bytes, std::ios::binary);
    const auto expected = openvdb::io::Stream(in, /*delayLoad=*/false).getGrids();
    ASSERT_EQ((*file)->grids().size(), expected->size());
    for (std::size_t i = 0; i < expected->size(); ++i) {
      const auto grid = (*file)->read(i);
      ASSERT_TRUE(grid) << grid.error().text();
      expectSameGrid(*grid->grid, *(*expected)[i]);
    }
  }
}

/// False sizes, counts, coordinates and flags: each file is rejected or read, and never makes the
/// reader allocate more memory than there is.
TEST(VdbFile, StandsHostileNumbersAnywhere) {
  const platform::TestFolder folder;
  const auto path = folder / "a.vdb";
  std::size_t refused = 0;
  for (const auto& [name, bytes] : vdbSamples()) {
    std::size_t step = 0;
    for (std::size_t at = 8; at + 8 <= bytes.size(); ++at) {
      // Most bytes of a small file belong to empty masks.
      if (bytes[at] == 0 || ++step % 41 != 0) continue;
      for (const std::int64_t lie : {std::int64_t{-1}, std::int64_t{-(1 << 20)},
                                     std::int64_t{1} << 40, std::int64_t{0x7FFFFFFF}}) {
        std::string hostile = bytes;
        std::memcpy(hostile.data() + at, &lie, sizeof lie);
        std::ofstream(path, std::ios::binary) << hostile;
        const auto file = VdbFile::open(path);
        bool whole = file.has_value();
        for (std::size_t i = 0; whole && i < (*file)->grids().size(); ++i) {
          whole = (*file)->read(i).has_value();
        }
        refused += whole ? 0 : 1;
      }
    }
  }
  EXPECT_GT(refused, 0U);
}

TEST(VdbFile, RefusesNumbersOfGridsThatCannotBe) {
  const platform::TestFolder folder;
  const auto path = folder / "a.vdb";
  // After the magic number, two versions, a flag, a UUID and a number of metadata, which is 0.
  constexpr std::size_t kAt = 8 + 4 + 8 + 1 + 36 + 4;
  for (const std::int32_t count : {-1, std::numeric_limits<std::int32_t>::max()}) {
    std::string bytes = vdbSamples().front().bytes;
    std::int32_t stored = 0;
    std::memcpy(&stored, bytes.data() + kAt, sizeof stored);
    ASSERT_EQ(stored, 1);
    std::memcpy(bytes.data() + kAt, &count, sizeof count);
    std::ofstream(path, std::ios::binary) << bytes;
    const auto file = VdbFile::open(path);
    ASSERT_FALSE(file);
    EXPECT_NE(file.error().message.find("it announces " + std::to_string(count) + " grids"),
              std::string::npos)
        << file.error().message;
  }
}

TEST(VdbFile, RefusesAnotherNumberOfVoxelsThanIsAnnounced) {
  const platform::TestFolder folder;
  const auto path = folder / "a.vdb";
  int changed = 0;
  for (const auto& [name, sample] : vdbSamples()) {
    // The name, the type with its length, the size of the value, and the value.
    const std::string field("file_voxel_count\5\0\0\0int64\x08\0\0\0", 29);
    const std::size_t at = sample.find(field);
    if (at == std::string::npos) continue;
    std::string bytes = sample;
    std::int64_t count = 0;
    std::memcpy(&count, bytes.data() + at + field.size(), sizeof count);
    const std::int64_t more = count + 3;
    std::memcpy(bytes.data() + at + field.size(), &more, sizeof more);
    std::ofstream(path, std::ios::binary) << bytes;
    const auto file = VdbFile::open(path);
    ASSERT_TRUE(file) << name;
    const auto grid = (*file)->read(0);
    ASSERT_FALSE(grid) << name;
    EXPECT_NE(grid.error().message.find(
                  fmt::format("it announces {} active voxels and has {}", more, count)),
              std::string::npos)
        << grid.error().message;
    ++changed;
  }
  EXPECT_GT(changed, 0);
}

TEST(VdbFile, RefusesOtherVersionsOfTheFormat) {
  const platform::TestFolder folder;
  const auto path = folder / "a.vdb";
  for (const char version : {'\xDD', '\xE1'}) {  // 221, 225
    std::string bytes = vdbSamples().front().bytes;
    bytes[8] = version;
    std::ofstream(path, std::ios::binary) << bytes;
    const auto file = VdbFile::open(path);
    ASSERT_FALSE(file);
    EXPECT_NE(file.error().message.find("versions 222 to 224"), std::string::npos);
  }
}

}  // namespace
}  // namespace t4d::voxel4d
