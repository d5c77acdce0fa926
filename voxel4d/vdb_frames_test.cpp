#include <cmath>
#include <fstream>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetSphere.h>

#include "model/parallel.h"
#include "platform/test_folder.h"
#include "t4d/frames.h"
#include "t4d/weave.h"
#include "voxel4d/natural_order.h"

namespace t4d::voxel4d {
namespace {

namespace fs = std::filesystem;

/// Grids as written by other programs, and the resulting frames.
class VdbFrames : public testing::Test {
 protected:
  static void SetUpTestSuite() { openvdb::initialize(); }

  static openvdb::FloatGrid::Ptr sphere(double radius, double voxelSize = 1) {
    auto grid = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(
        static_cast<float>(radius), openvdb::Vec3f(0.5F, 0.25F, 0), static_cast<float>(voxelSize));
    grid->setName("ball");
    return grid;
  }

  template <class Grid>
  static typename Grid::Ptr timed(typename Grid::Ptr grid, double time) {
    grid->insertMeta(kTimeMetadata, openvdb::DoubleMetadata(time));
    return grid;
  }
  static openvdb::FloatGrid::Ptr sphereAt(double time, double radius = 10) {
    return timed<openvdb::FloatGrid>(sphere(radius), time);
  }

  fs::path write(const std::string& name, const openvdb::GridCPtrVec& grids) {
    openvdb::io::File((folder_ / name).string()).write(grids);
    return folder_ / name;
  }

  /// `name.vdb` with two frames, the first valid.
  std::vector<fs::path> afterGood(const openvdb::GridBase::Ptr& second) {
    return {write("frame1.vdb", {sphereAt(0)}), write("frame2.vdb", {second})};
  }

  std::vector<Frame> read(const std::vector<fs::path>& inputs,
                          const VdbFramesOptions& options = {}) {
    std::vector<Frame> frames;
    auto source = openVdbFrames(inputs, options);
    EXPECT_TRUE(source) << source.error().text();
    if (!source) return frames;
    for (std::size_t i = 0; i < (*source)->frameCount(); ++i) {
      auto frame = (*source)->frame(i);
      EXPECT_TRUE(frame) << frame.error().text();
      if (frame) frames.push_back(std::move(*frame));
    }
    return frames;
  }

  /// The error of opening the inputs or of reading their frames.
  static std::optional<Error> errorOf(const std::vector<fs::path>& inputs,
                                      const VdbFramesOptions& options = {}) {
    auto source = openVdbFrames(inputs, options);
    if (!source) return source.error();
    for (std::size_t i = 0; i < (*source)->frameCount(); ++i) {
      if (auto frame = (*source)->frame(i); !frame) return frame.error();
    }
    return std::nullopt;
  }

  std::string refusal(const std::vector<fs::path>& inputs, const VdbFramesOptions& options = {}) {
    const auto error = errorOf(inputs, options);
    return error ? folder_.without(error->text()) : "(was accepted)";
  }

  platform::TestFolder folder_;
};

void expectSame(const Frame& a, const Frame& b) {
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.outsideValue, b.outsideValue);
  ASSERT_EQ(a.blocks.size(), b.blocks.size());
  ASSERT_EQ(a.tiles.size(), b.tiles.size());
  for (std::size_t i = 0; i < a.blocks.size(); ++i) {
    EXPECT_EQ(a.blocks[i].coord, b.blocks[i].coord);
    EXPECT_EQ(a.blocks[i].inside, b.blocks[i].inside);
    ValueBuffer buffers[2];
    const BlockValues values = valuesOf(a, i, buffers[0]);
    const BlockValues others = valuesOf(b, i, buffers[1]);
    ASSERT_EQ(values.empty(), others.empty());
    for (unsigned j = 0; !values.empty() && j < 512; ++j) ASSERT_EQ(values.at(j), others.at(j));
  }
  for (std::size_t i = 0; i < a.tiles.size(); ++i) {
    EXPECT_EQ(a.tiles[i].coord, b.tiles[i].coord);
    EXPECT_EQ(a.tiles[i].size, b.tiles[i].size);
    EXPECT_EQ(a.tiles[i].value, b.tiles[i].value);
  }
}

TEST(NaturalOrder, NumbersCountAsNumbers) {
  EXPECT_TRUE(naturallyLess("frame2.vdb", "frame10.vdb"));
  EXPECT_FALSE(naturallyLess("frame10.vdb", "frame2.vdb"));
  EXPECT_TRUE(naturallyLess("frame0009.vdb", "frame10.vdb"));
  EXPECT_TRUE(naturallyLess("a9b10", "a9b11"));
  EXPECT_TRUE(naturallyLess("a", "a1"));
  EXPECT_TRUE(naturallyLess("x99999999999999999999998", "x99999999999999999999999"));
  EXPECT_FALSE(naturallyLess("same7", "same7"));
  EXPECT_NE(naturallyLess("f01", "f1"), naturallyLess("f1", "f01"));
}

TEST_F(VdbFrames, FolderInNaturalOrder) {
  for (const int i : {1, 2, 10, 9, 100}) {
    write("frame" + std::to_string(i) + ".vdb", {sphereAt(i)});
  }
  std::ofstream(folder_ / "notes.txt") << "not a frame";
  std::ofstream(folder_ / ".hidden.vdb") << "not a frame either";
  std::vector<double> times;
  for (const Frame& frame : read({folder_.path()})) times.push_back(frame.time);
  EXPECT_EQ(times, (std::vector<double>{1, 2, 9, 10, 100}));
}

TEST_F(VdbFrames, OneFileOfSeveralGrids) {
  openvdb::GridCPtrVec grids;
  for (int i = 0; i < 12; ++i) grids.push_back(sphereAt(i, 5 + i));
  const auto frames = read({write("all.vdb", grids)});
  ASSERT_EQ(frames.size(), 12U);
  for (int i = 0; i < 12; ++i) EXPECT_EQ(frames[i].time, i);
  EXPECT_GT(countInside(frames[11]), countInside(frames[10]));
}

TEST_F(VdbFrames, GridsThatShareATree) {
  const auto first = sphereAt(0);
  const auto second = openvdb::gridPtrCast<openvdb::FloatGrid>(first->copyGrid());
  timed<openvdb::FloatGrid>(second, 1);
  const auto frames = read({write("shared.vdb", {first, second})});
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(countInside(frames[0]), countInside(frames[1]));
  EXPECT_GT(countInside(frames[0]), 4000U);
}

TEST_F(VdbFrames, FilesThatWereStreamed) {
  const auto path = folder_ / "streamed.vdb";
  {
    std::ofstream out(path, std::ios::binary);
    openvdb::io::Stream(out).write(openvdb::GridCPtrVec{sphereAt(0), sphereAt(1, 12)});
  }
  const auto frames = read({path});
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_GT(countInside(frames[1]), countInside(frames[0]));
  const auto size = fs::file_size(path);
  for (const auto left : {size - 1, size / 2, size / 4}) {
    fs::resize_file(path, left);
    EXPECT_NE(refusal({path}).find("cut off"), std::string::npos) << refusal({path});
  }
}

TEST_F(VdbFrames, BlocksPointIntoTheGridAndTilesAreInside) {
  const auto grid = sphereAt(0, 100);
  const auto frames = read({write("a.vdb", {grid, sphereAt(1, 100)})});
  ASSERT_EQ(frames.size(), 2U);
  const Frame& frame = frames[0];
  EXPECT_EQ(frame.outsideValue, 3);
  EXPECT_EQ(frame.blocks.size(), grid->tree().leafCount());
  std::uint64_t expected = 0;
  for (auto value = grid->cbeginValueAll(); value; ++value) {
    if (*value < 0) expected += value.getVoxelCount();
  }
  EXPECT_EQ(countInside(frame), expected);
  EXPECT_NEAR(static_cast<double>(countInside(frame)), 4.0 / 3 * M_PI * 1e6, 3e4);
  for (const Block& block : frame.blocks) {
    const openvdb::Coord origin(8 * block.coord.x, 8 * block.coord.y, 8 * block.coord.z);
    for (const unsigned i : {0U, 77U, 300U, 511U}) {
      const auto at = origin.offsetBy(static_cast<int>(i / 64), static_cast<int>(i / 8 % 8),
                                      static_cast<int>(i % 8));
      ASSERT_EQ(block.values.at(i), grid->tree().getValue(at));
      ASSERT_EQ((block.inside[i / 64] >> (i % 64) & 1) != 0, grid->tree().getValue(at) < 0);
    }
  }
  for (const InsideTile& tile : frame.tiles) EXPECT_EQ(tile.value, -3);
}

TEST_F(VdbFrames, LargeOnesHaveTheirValuesInAFile) {
  auto floats = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(30, {5, -7, 300}, 1);
  auto halves = floats->deepCopy();
  halves->setSaveFloatAsHalf(true);
  auto doubles = openvdb::DoubleGrid::create(3);
  doubles->tree().topologyUnion(floats->tree());
  for (auto value = doubles->beginValueOn(); value; ++value) {
    value.setValue(floats->tree().getValue(value.getCoord()) / 3);
  }
  const std::vector<openvdb::GridBase::Ptr> grids = {floats, halves, doubles};
  for (const auto& grid : grids) {
    const auto path = write("large.vdb", {grid, grid->deepCopyGrid()});
    const auto expected = read({path}, {.frameTime = 1});
    const auto found = read({path}, {.frameTime = 1, .largeFrame = 0});
    ASSERT_EQ(found.size(), 2U);
    EXPECT_EQ(found[1].owner, nullptr);
    ASSERT_NE(found[1].file, nullptr);
    for (std::size_t i = 0; i < 2; ++i) expectSame(found[i], expected[i]);
    EXPECT_TRUE(checkFrame(found[1]));
  }
}

/// Tiles of all levels, leaf nodes, and voxels that are inside and inactive.
template <class Grid>
typename Grid::Ptr tiled(double time) {
  using Value = typename Grid::ValueType;
  const Value inside = std::is_same_v<Value, bool> ? Value(1) : Value(-3);
  auto grid = Grid::create(std::is_same_v<Value, bool> ? Value(0) : Value(3));
  grid->setName("solid");
  grid->insertMeta(kTimeMetadata, openvdb::DoubleMetadata(time));
  auto& tree = grid->tree();
  tree.addTile(1, {16, 0, 0}, inside, true);
  tree.addTile(1, {16, 8, -8}, inside, true);
  tree.addTile(2, {-128, 0, 0}, inside, true);
  for (int i = 0; i < 300; ++i) {
    const openvdb::Coord at(i * 7 % 23 - 6, i * 5 % 17, i * 3 % 29 - 9);
    if (std::is_same_v<Value, bool> || i % 3 > 0) {
      tree.setValueOn(at, std::is_same_v<Value, bool> ? Value(1) : Value(i % 5 - 2.5));
    } else {
      tree.setValueOff(at, inside);
    }
  }
  return grid;
}

model::Mesh woven(const fs::path& path, const VdbFramesOptions& options = {}) {
  model::Mesh mesh;
  auto source = openVdbFrames(std::vector{path}, options);
  EXPECT_TRUE(source) << source.error().text();
  EXPECT_TRUE(source && weave(**source, {}, mesh));
  return mesh;
}

TEST_F(VdbFrames, ARegionIsTheGridThatOpenVdbClips) {
  const auto check = [&]<class Grid>(const typename Grid::Ptr&) {
    for (const std::string ranges :
         {"-5:12,3:9,:", "0:20,:,-3:4", "-100:-90,10:30,5:6", "17:19,-99:99,-99:99",
          "-64:64,-64:64,-64:64", ":,:,:", "-3:-2,2:3,0:1"}) {
      const Region region = *parseRegion(ranges);
      openvdb::CoordBBox box = openvdb::CoordBBox::inf();
      for (int axis = 0; axis < 3; ++axis) {
        const auto& [begin, end] = region.space[axis];
        if (begin) box.min()[axis] = static_cast<std::int32_t>(*begin);
        if (end) box.max()[axis] = static_cast<std::int32_t>(*end - 1);
      }
      openvdb::GridCPtrVec whole;
      openvdb::GridCPtrVec clipped;
      for (const double time : {0.0, 1.0, 2.0, 3.0}) {
        whole.push_back(tiled<Grid>(time));
        if (time == 0 || time == 3) continue;
        const auto grid = tiled<Grid>(time);
        grid->clip(box);
        clipped.push_back(grid);
      }
      const auto from = write("whole.vdb", whole);
      const model::Mesh expected = woven(write("clipped.vdb", clipped));
      VdbFramesOptions options;
      options.region = region;
      options.region->time = {1, 3};
      for (const std::size_t large : {std::size_t{0}, kLargeFrame}) {
        SCOPED_TRACE(ranges + (large == 0 ? " in a file" : ""));
        options.largeFrame = large;
        const model::Mesh found = woven(from, options);
        ASSERT_EQ(found.slabCount(), 3U);
        ASSERT_EQ(expected.slabCount(), 3U);
        for (std::size_t i = 0; i < 3; ++i) {
          EXPECT_FALSE(found.slabs()[i].vertices.empty());
          EXPECT_TRUE(found.slabs()[i].vertices == expected.slabs()[i].vertices);
          EXPECT_TRUE(*found.slabs()[i].connectivity == *expected.slabs()[i].connectivity);
        }
      }
    }
  };
  check.operator()<openvdb::FloatGrid>({});
  check.operator()<openvdb::DoubleGrid>({});
  check.operator()<openvdb::BoolGrid>({});
  check.operator()<openvdb::MaskGrid>({});
}

TEST_F(VdbFrames, ARegionSaysWhereItCutsTheSolid) {
  const auto path = write("balls.vdb", {sphereAt(0), sphereAt(1), sphereAt(2, 5)});
  const auto noticeWith = [&](const std::string& ranges) {
    auto source = *openVdbFrames(std::vector{path}, {.region = *parseRegion(ranges)});
    for (std::size_t i = 0; i < source->frameCount(); ++i) EXPECT_TRUE(source->frame(i));
    return source->notice();
  };
  EXPECT_EQ(noticeWith("-11:12,-11:12,-11:12"), "");
  EXPECT_TRUE(noticeWith("-3:12,:,:9").ends_with("closed there: at x = -3, z = 8"));
  EXPECT_EQ(refusal({path}, {.region = *parseRegion(":,:,:,1:4")}),
            "balls.vdb: the region has 1:4 along t, where there are 3 frames, counted from 0");
  EXPECT_TRUE(refusal({path}, {.region = *parseRegion("100:120,:,:")}).ends_with("is inside"));
}

TEST_F(VdbFrames, TilesOfAllLevels) {
  auto grid = openvdb::BoolGrid::create(false);
  grid->tree().addTile(1, {8, 0, 0}, true, false);
  grid->tree().addTile(2, {-128, 0, 128}, true, true);
  grid->tree().addTile(3, {4096, 4096, -4096}, true, true);
  grid->tree().addTile(1, {80, 0, 0}, false, true);
  const auto frames = read({write("a.vdb", {grid, grid->deepCopyGrid()})}, {.frameTime = 0.5});
  ASSERT_EQ(frames.size(), 2U);
  const auto& tiles = frames[0].tiles;
  ASSERT_EQ(tiles.size(), 3U);
  EXPECT_EQ(tiles[0].coord, (Coord{-16, 0, 16}));
  EXPECT_EQ(tiles[0].size, 16);
  EXPECT_EQ(tiles[1].coord, (Coord{1, 0, 0}));
  EXPECT_EQ(tiles[1].size, 1);
  EXPECT_EQ(tiles[2].coord, (Coord{512, 512, -512}));
  EXPECT_EQ(tiles[2].size, 512);
}

TEST_F(VdbFrames, TransformCarriesOver) {
  const auto make = [&] {
    auto grid = sphere(3, 0.25);
    grid->transform().postTranslate({1, -2, 0.5});
    return grid;
  };
  const auto path = write("a.vdb", {make(), make()});
  const auto source = openVdbFrames(std::vector{path}, {.frameTime = 0.1, .startTime = -1});
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_EQ((*source)->lattice(), (Lattice{0.25, {1, -2, 0.5}}));
  EXPECT_EQ((*source)->frame(0)->time, -1);
  EXPECT_EQ((*source)->frame(1)->time, -0.9);
}

TEST_F(VdbFrames, DoublesAndDensitiesAreTheLevelSet) {
  const auto levelSet = [&](double time) { return sphereAt(time, 20); };
  const auto asDouble = [&](double time) {
    auto grid = openvdb::DoubleGrid::create(3);
    grid->setTree(std::make_shared<openvdb::DoubleTree>(levelSet(time)->tree()));
    return timed<openvdb::DoubleGrid>(grid, time);
  };
  const auto density = [&](double time) {
    auto grid = openvdb::DoubleGrid::create(5 - 3);
    const auto distances = asDouble(time);
    for (auto value = distances->cbeginValueAll(); value; ++value) {
      if (value.isVoxelValue()) {
        grid->tree().setValue(value.getCoord(), 5 - *value);
      } else if (*value < 0) {
        grid->tree().addTile(value.getLevel(), value.getCoord(), 5 - *value, value.isValueOn());
      }
    }
    return timed<openvdb::DoubleGrid>(grid, time);
  };
  const auto expected = read({write("l.vdb", {levelSet(0), levelSet(1)})});
  const auto doubles = read({write("d.vdb", {asDouble(0), asDouble(1)})});
  const auto densities = read({write("f.vdb", {density(0), density(1)})}, {.iso = 5});
  ASSERT_EQ(expected.size(), 2U);
  ASSERT_EQ(doubles.size(), 2U);
  ASSERT_EQ(densities.size(), 2U);
  for (int i = 0; i < 2; ++i) {
    expectSame(doubles[i], expected[i]);
    ASSERT_EQ(densities[i].blocks.size(), expected[i].blocks.size());
    EXPECT_EQ(countInside(densities[i]), countInside(expected[i]));
    for (std::size_t b = 0; b < expected[i].blocks.size(); ++b) {
      EXPECT_EQ(densities[i].blocks[b].inside, expected[i].blocks[b].inside);
      for (unsigned j = 0; j < 512; ++j) {
        ASSERT_NEAR(densities[i].blocks[b].values.at(j), expected[i].blocks[b].values.at(j), 1e-14);
      }
    }
  }
}

TEST_F(VdbFrames, BackgroundOnTheIsoValueIsOutside) {
  auto grid = openvdb::FloatGrid::create(0);
  grid->tree().setValue({0, 0, 0}, 1);
  const auto frames =
      read({write("a.vdb", {grid, grid->deepCopyGrid()})}, {.iso = 0, .frameTime = 1});
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(countInside(frames[0]), 1U);
  EXPECT_TRUE(frames[0].hasValues());
  EXPECT_GT(frames[0].outsideValue, 0);
}

TEST_F(VdbFrames, BoolsByValueAndMasksByState) {
  auto bools = openvdb::BoolGrid::create(false);
  bools->tree().setValueOn({1, 2, 3}, true);
  bools->tree().setValueOff({1, 2, 4}, true);
  bools->tree().setValueOn({-1, -2, 5}, false);
  auto masks = openvdb::MaskGrid::create();
  masks->tree().setValueOn({1, 2, 3});
  masks->tree().setValueOn({1, 2, 4});
  masks->tree().setValueOn({-1, 0, 0});
  const auto a = read({write("a.vdb", {bools, bools->deepCopyGrid()})}, {.frameTime = 1});
  const auto b = read({write("b.vdb", {masks, masks->deepCopyGrid()})}, {.frameTime = 1});
  ASSERT_EQ(a.size(), 2U);
  ASSERT_EQ(b.size(), 2U);
  EXPECT_EQ(countInside(a[0]), 2U);
  EXPECT_EQ(countInside(b[0]), 3U);
  EXPECT_FALSE(a[0].hasValues());
  ASSERT_EQ(b[0].blocks.size(), 2U);
  EXPECT_EQ(b[0].blocks[1].coord, (Coord{0, 0, 0}));
  EXPECT_EQ(b[0].blocks[1].inside[1], std::uint64_t{3} << (8 * 2 + 3));
  EXPECT_TRUE(b[0].blocks[1].values.empty());
}

TEST_F(VdbFrames, FramesWithoutSurfaceAreAllowedBetweenOthers) {
  const auto nothing = [](double time) {
    auto grid = openvdb::FloatGrid::create(3);
    grid->setName("ball");
    return timed<openvdb::FloatGrid>(grid, time);
  };
  const auto frames = read({write("a.vdb", {sphereAt(0), nothing(1), nothing(2), sphereAt(3)})});
  ASSERT_EQ(frames.size(), 4U);
  EXPECT_EQ(countInside(frames[1]), 0U);
  EXPECT_EQ(frames[1].outsideValue, 3);
}

TEST_F(VdbFrames, OneOfSeveralGridsByName) {
  const auto density = [](double time) {
    auto grid = openvdb::Vec3SGrid::create();
    grid->setName("velocity");
    return timed<openvdb::Vec3SGrid>(grid, time);
  };
  const std::vector<fs::path> files = {write("a1.vdb", {sphereAt(0), density(0)}),
                                       write("a2.vdb", {sphereAt(1), density(1)})};
  EXPECT_EQ(read(files, {.grid = "ball"}).size(), 2U);
  EXPECT_EQ(refusal(files),
            "a1.vdb: holds 2 grids ('ball', 'velocity'); where there are several files, each must "
            "hold one");
  EXPECT_EQ(errorOf(files)->remedy, Remedy::GridName);
  EXPECT_EQ(refusal(files, {.grid = "bell"}),
            "a1.vdb: holds no grid 'bell'; it has 'ball', 'velocity'");
}

TEST_F(VdbFrames, AreTheSameForAnyNumberOfThreads) {
  const auto path = write("a.vdb", {sphereAt(0, 60), sphereAt(1, 61)});
  const auto run = [&](std::size_t threads) {
    const model::ThreadLimit limit(threads);
    return read({path});
  };
  const auto one = run(1);
  const auto many = run(8);
  ASSERT_EQ(one.size(), many.size());
  for (std::size_t i = 0; i < one.size(); ++i) expectSame(one[i], many[i]);
}

TEST_F(VdbFrames, RefusesTooFewFrames) {
  EXPECT_EQ(refusal({}), "no frames: no .vdb file is given");
  fs::create_directories(folder_ / "empty");
  EXPECT_EQ(refusal({folder_ / "empty"}), "empty: no frames: the folder has no .vdb files");
  EXPECT_EQ(refusal({write("one.vdb", {sphereAt(0)})}),
            "one.vdb: grid 'ball': one frame only; a 4D mesh needs two or more");
  EXPECT_EQ(refusal({write("none.vdb", {})}), "none.vdb: holds no grid");
}

TEST_F(VdbFrames, RefusesWhatIsNotVdb) {
  EXPECT_EQ(refusal({folder_ / "missing.vdb"}),
            "missing.vdb: cannot open: No such file or directory");
  std::ofstream(folder_ / "text.vdb") << "This is text, not a grid.";
  EXPECT_EQ(refusal({folder_ / "text.vdb"}), "text.vdb: is not a VDB file");
  std::ofstream(folder_ / "short.vdb") << " BDV";
  EXPECT_EQ(refusal({folder_ / "short.vdb"}), "short.vdb: is not a VDB file");
  std::ofstream(folder_ / "empty.vdb").flush();
  EXPECT_EQ(refusal({folder_ / "empty.vdb"}), "empty.vdb: is empty");
}

TEST_F(VdbFrames, RefusesEveryCutOffFile) {
  const auto path = write("a.vdb", {sphereAt(0, 3), sphereAt(1, 3)});
  EXPECT_EQ(refusal({path}), "(was accepted)");
  const auto size = fs::file_size(path);
  const auto copy = folder_ / "cut.vdb";
  for (std::uintmax_t left = 0; left < size; left += std::max<std::uintmax_t>(1, size / 499)) {
    fs::copy_file(path, copy, fs::copy_options::overwrite_existing);
    fs::resize_file(copy, left);
    const std::string text = refusal({copy});
    EXPECT_EQ(text.rfind("cut.vdb", 0), 0U) << left << ": " << text;
    EXPECT_TRUE(text.find("cut off") != text.npos || text.find("not a VDB") != text.npos ||
                text.find("is empty") != text.npos)
        << left << ": " << text;
  }
  fs::resize_file(path, size - 1);
  EXPECT_EQ(refusal({path}), "a.vdb: is cut off: its grid 'ball[1]' ends at byte " +
                                 std::to_string(size) + ", the file has " +
                                 std::to_string(size - 1));
}

TEST_F(VdbFrames, DamagedBytesDoNoHarm) {
  const auto path = write("a.vdb", {sphereAt(0, 3), sphereAt(1, 3)});
  const auto size = static_cast<std::int64_t>(fs::file_size(path));
  const auto copy = folder_ / "damaged.vdb";
  int refused = 0;
  for (std::int64_t at = 8; at < size; at += std::max<std::int64_t>(1, size / 701)) {
    fs::copy_file(path, copy, fs::copy_options::overwrite_existing);
    std::fstream file(copy, std::ios::binary | std::ios::in | std::ios::out);
    file.seekg(at);
    const int byte = file.get();
    file.seekp(at);
    file.put(static_cast<char>(byte ^ (at % 2 == 0 ? 0xFF : 0x10)));
    file.close();
    refused += refusal({copy}) == "(was accepted)" ? 0 : 1;
  }
  EXPECT_GT(refused, 0);
}

TEST_F(VdbFrames, RefusesOtherTypesByName) {
  auto vectors = timed<openvdb::Vec3SGrid>(openvdb::Vec3SGrid::create(), 1);
  vectors->setName("velocity");
  EXPECT_EQ(refusal(afterGood(vectors)),
            "frame2.vdb: grid 'velocity': is a grid of type vec3s (Tree_vec3s_5_4_3); float, "
            "double, bool and mask grids can be used");
  auto integers = timed<openvdb::Int32Grid>(openvdb::Int32Grid::create(), 1);
  EXPECT_NE(refusal(afterGood(integers)).find("type int32"), std::string::npos);
  auto masks = timed<openvdb::MaskGrid>(openvdb::MaskGrid::create(), 1);
  EXPECT_NE(
      refusal(afterGood(masks)).find("is a grid of type mask, the first frame one of type float"),
      std::string::npos)
      << refusal(afterGood(masks));
}

TEST_F(VdbFrames, RefusesTypesThatOpenVdbDoesNotKnow) {
  using Tree = openvdb::tree::Tree4<float, 4, 3, 3>::Type;
  using Grid = openvdb::Grid<Tree>;
  auto grid = timed<Grid>(Grid::create(3), 1);
  grid->setName("odd");
  EXPECT_EQ(refusal(afterGood(grid)),
            "frame2.vdb: its grid 'odd' is of type Tree_float_4_3_3; float, double, bool and mask "
            "grids can be used");
}

/// A ball that moves by 6 voxels along x from frame to frame.
openvdb::FloatGrid::Ptr movingBall(int frame) {
  auto grid = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(
      6, openvdb::Vec3f(6.0F * static_cast<float>(frame), 0, 0), 1);
  grid->setName("ball");
  return grid;
}

/// Its velocity where |x| and so on are below `reach`, for frames that are half a time unit apart.
openvdb::Vec3SGrid::Ptr velocityOf(int frame, openvdb::GridClass kind, int reach = 8) {
  auto grid = openvdb::Vec3SGrid::create();
  grid->setName("vel");
  grid->setGridClass(kind);
  const int x = 6 * frame;
  grid->fill({{x - reach, -reach, -reach}, {x + reach, reach, reach}}, openvdb::Vec3f(12, 0, 0));
  return grid;
}

class VdbVelocities : public VdbFrames {
 protected:
  using Change = std::function<void(openvdb::GridPtrVec&)>;

  /// Two frames with their velocities; the grids of the second are changed.
  std::vector<fs::path> files(openvdb::GridClass kind, const Change& change = {}) {
    std::vector<fs::path> files;
    for (int frame = 0; frame < 2; ++frame) {
      openvdb::GridPtrVec grids = {movingBall(frame), velocityOf(frame, kind)};
      if (frame == 1 && change) change(grids);
      files.push_back(write("f" + std::to_string(frame) + ".vdb", {grids.begin(), grids.end()}));
    }
    return files;
  }
  static VdbFramesOptions halfway() { return {.frameTime = 0.5, .velocity = "vel", .substeps = 2}; }
  std::string refusalOf(const Change& change) {
    return refusal(files(openvdb::GRID_UNKNOWN, change), halfway());
  }
  /// Frame 1 is the ball halfway.
  void expectHalfway(const std::vector<Frame>& frames) {
    ASSERT_EQ(frames.size(), 3U);
    EXPECT_EQ(frames[1].time, 0.25);
    const double ball = static_cast<double>(countInside(frames[0]));
    EXPECT_NEAR(static_cast<double>(countInside(frames[1])), ball, 0.02 * ball);
  }
};

TEST_F(VdbVelocities, CarryTheSolidBetweenFrames) {
  expectHalfway(read(files(openvdb::GRID_UNKNOWN), halfway()));
  expectHalfway(read(files(openvdb::GRID_STAGGERED), halfway()));
  const auto frames = read(files(openvdb::GRID_UNKNOWN), {.frameTime = 0.5, .grid = "ball"});
  const auto carried = read(files(openvdb::GRID_UNKNOWN), halfway());
  expectSame(frames[0], carried[0]);
  expectSame(frames[1], carried[2]);
}

TEST_F(VdbVelocities, MayBeThreeGridsWithVoxelsOfTheirOwn) {
  std::vector<fs::path> files;
  for (int frame = 0; frame < 2; ++frame) {
    openvdb::GridCPtrVec grids = {movingBall(frame)};
    for (const char* axis : {"x", "y", "z"}) {
      auto grid = openvdb::FloatGrid::create();
      grid->setName(std::string("vel_") + axis);
      grid->setTransform(openvdb::math::Transform::createLinearTransform(2));
      grid->transform().postTranslate({0.5, 0, 0});
      grid->fill({{-10, -10, -10}, {10, 10, 10}}, *axis == 'x' ? 12.0F : 0.0F);
      grids.push_back(grid);
    }
    files.push_back(write("f" + std::to_string(frame) + ".vdb", grids));
  }
  expectHalfway(read(files, halfway()));
}

TEST_F(VdbVelocities, AreRefusedIfTheyCannotBeRight) {
  const auto changed = [&](const std::function<void(openvdb::Vec3SGrid&)>& change) {
    return refusalOf([&](openvdb::GridPtrVec& grids) {
      change(*openvdb::gridPtrCast<openvdb::Vec3SGrid>(grids[1]));
    });
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(changed([&](auto& grid) {
              grid.tree().setValueOn({5, 1, 2}, {0, nan, 0});
            }),
            "f1.vdb: grid 'vel': has a velocity that is not finite, at the voxel (5, 1, 2)");
  EXPECT_EQ(changed([](auto& grid) {
              grid.tree().setValueOn({12, 0, 0}, {1e30F, 0, 0});
            }).substr(0, 63),
            "f1.vdb: grid 'vel': moves the surface by 5e+29 voxels from fram");
  EXPECT_EQ(changed([](auto& grid) {
              grid.transform().postTranslate({500, 0, 0});
            }),
            "f1.vdb: grid 'vel': none of its velocities is near the surface of the frame: its "
            "transform may be another");
  EXPECT_THAT(changed([](auto& grid) { grid.transform().postRotate(0.5); }),
              testing::HasSubstr("f1.vdb: grid 'vel': its transform takes"));
  EXPECT_EQ(refusalOf([](openvdb::GridPtrVec& grids) { grids.pop_back(); }),
            "f1.vdb: holds no grid 'vel'; it has 'ball'");
  EXPECT_EQ(refusalOf([](openvdb::GridPtrVec& grids) {
              grids[1] = movingBall(1);
              grids[1]->setName("vel");
            }),
            "f1.vdb: grid 'vel': is a grid of type float; a velocity is a vec3s grid, or three "
            "float grids");
  EXPECT_EQ(refusal(files(openvdb::GRID_UNKNOWN), {.velocity = "vel", .substeps = 2}),
            "f0.vdb: velocities need the time from frame to frame, and no grid has a number "
            "'t4d_time' in its metadata");
  EXPECT_EQ(
      refusal(files(openvdb::GRID_UNKNOWN), {.frameTime = 1, .velocity = "wind", .substeps = 2}),
      "f0.vdb: holds no velocity 'wind', neither as a vec3s grid nor as three float grids "
      "such as 'wind.x'; it has 'ball', 'vel'");
}

TEST_F(VdbFrames, ValuesBelowTheIsoValueAreInsideOnRequest) {
  const auto raised = [&](double time) {
    auto grid = sphereAt(time);
    for (auto value = grid->beginValueAll(); value; ++value) value.setValue(*value + 5);
    grid->tree().root().setBackground(grid->background() + 5, true);
    return grid;
  };
  const auto expected = read({write("l.vdb", {sphereAt(0), sphereAt(1)})});
  const auto found = read({write("r.vdb", {raised(0), raised(1)})}, {.iso = 5, .below = true});
  ASSERT_EQ(found.size(), 2U);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(countInside(found[i]), countInside(expected[i]));
    EXPECT_EQ(found[i].blocks.front().inside, expected[i].blocks.front().inside);
  }
  EXPECT_NE(refusal({write("r.vdb", {raised(0), raised(1)})}, {.iso = 9, .below = true})
                .find("its background 8 is inside"),
            std::string::npos);
}

TEST_F(VdbFrames, FilesStayInTheOrderGiven) {
  const fs::path b = write("b.vdb", {sphereAt(0)});
  const fs::path a = write("a.vdb", {sphereAt(1)});
  std::vector<double> times;
  for (const Frame& frame : read({b, a}, {.times = {3, 8}})) times.push_back(frame.time);
  EXPECT_EQ(times, (std::vector<double>{3, 8}));
  EXPECT_EQ(read({b, a}).size(), 2U);
  EXPECT_NE(refusal({a, b}).find("times do not increase"), std::string::npos);
  EXPECT_NE(refusal({b, a}, {.times = {3}}).find("1 time for 2 frames"), std::string::npos);
}

TEST_F(VdbFrames, RefusesOtherTransforms) {
  const auto with = [&](const auto& change) {
    auto grid = sphereAt(1);
    change(grid->transform());
    return refusal(afterGood(grid));
  };
  using openvdb::math::Transform;
  EXPECT_EQ(with([](Transform& t) {
              t.postTranslate({0, 0, 1});
            }),
            "frame2.vdb: grid 'ball': its transform has voxel size 1 and origin (0, 0, 1), that of "
            "the first frame voxel size 1 and origin (0, 0, 0): a corner of its voxels is 1 voxels "
            "away from there; up to 0.001 are taken for rounding");
  // The ball has voxels up to 13 from the middle, and half as far with the other transform.
  EXPECT_EQ(with([](Transform& t) { t.postScale(0.5); }),
            "frame2.vdb: grid 'ball': its transform has voxel size 0.5 and origin (0, 0, 0), that "
            "of the first frame voxel size 1 and origin (0, 0, 0): a corner of its voxels is 10.98 "
            "voxels away from there; up to 0.001 are taken for rounding");
  EXPECT_EQ(with([](Transform& t) { t.postScale(1 + 4e-5); }), "(was accepted)");
  EXPECT_EQ(with([](Transform& t) { t.postTranslate({0, 0, 1e-6}); }), "(was accepted)");
  EXPECT_NE(with([](Transform& t) { t.postScale(1 + 6e-5); }), "(was accepted)");
  EXPECT_EQ(with([](Transform& t) { t.postScale(openvdb::Vec3d(1, 1, 2)); }),
            "frame2.vdb: grid 'ball': its transform takes a voxel's axes to (1, 0, 0), (0, 1, 0), "
            "(0, 0, 2); only a uniform scale with a translation can be used: resample it");
  EXPECT_NE(with([](Transform& t) { t.postRotate(0.1); }).find("only a uniform scale"),
            std::string::npos);
  EXPECT_NE(with([](Transform& t) { t.postScale(-1); }).find("only a uniform scale"),
            std::string::npos);
  auto frustum = sphereAt(1);
  frustum->setTransform(Transform::createFrustumTransform({{0, 0, 0}, {9, 9, 9}}, 0.5, 1, 1));
  EXPECT_NE(refusal(afterGood(frustum)).find("its transform is a NonlinearFrustumMap"),
            std::string::npos);
}

TEST_F(VdbFrames, RefusesATransformThatCannotBeUndone) {
  const auto files = afterGood(sphereAt(1));
  std::string bytes = platform::contents(files[1]);
  const std::string type = "UniformScaleMap";
  bytes.replace(bytes.find(type) + type.size(), 24, 24, '\0');
  std::ofstream(files[1], std::ios::binary) << bytes;
  EXPECT_EQ(refusal(files).substr(0, 70),
            "frame2.vdb: grid 'ball': its transform takes a voxel's axes to (0, 0, ");
}

TEST_F(VdbFrames, WithoutAnyTimesAreOneApart) {
  const auto frames = openVdbFrames(std::vector{write("a.vdb", {sphere(10), sphere(9)})});
  ASSERT_TRUE(frames) << frames.error().text();
  EXPECT_TRUE((*frames)->isOneApart());
  EXPECT_EQ((*frames)->frame(0)->time, 0);
  EXPECT_EQ((*frames)->frame(1)->time, 1);
}

TEST_F(VdbFrames, RefusesTimesThatAreMissingOrDoNotIncrease) {
  EXPECT_EQ(refusal({write("a.vdb", {sphereAt(0), sphere(10)})}),
            "a.vdb: grid 'ball[1]': has no time: no number 't4d_time' in its metadata");
  EXPECT_EQ(errorOf({folder_ / "a.vdb"})->remedy, Remedy::FrameTime);
  EXPECT_EQ(refusal({write("b.vdb", {sphereAt(0.5), sphereAt(0.5)})}).substr(0, 78),
            "b.vdb: grid 'ball[1]': times do not increase: its time is 0.5, that of the fra");
  EXPECT_NE(refusal({write("c.vdb", {sphereAt(0.5), sphereAt(NAN)})}).find("its time is nan"),
            std::string::npos);
  const auto good = write("d.vdb", {sphereAt(0), sphereAt(1)});
  for (const double step : {0.0, -1.0, double(NAN), double(INFINITY)}) {
    EXPECT_NE(refusal({good}, {.frameTime = step}).find("must be a positive number"),
              std::string::npos);
  }
  EXPECT_NE(refusal({good}, {.frameTime = 1e-3, .startTime = 1e15}).find("doubles are too coarse"),
            std::string::npos);
}

TEST_F(VdbFrames, RefusesValuesThatAreNotFinite) {
  for (const float bad : {NAN, INFINITY, -INFINITY}) {
    auto grid = sphereAt(1);
    grid->tree().setValueOff({10, 1, 2}, bad);
    EXPECT_EQ(refusal(afterGood(grid)),
              "frame2.vdb: grid 'ball': has values that are not finite, at or near the voxel (8, "
              "0, 0)");
    auto tile = sphereAt(1);
    tile->tree().addTile(1, {80, 80, 80}, bad, false);
    EXPECT_NE(refusal(afterGood(tile)).find("not finite"), std::string::npos);
    EXPECT_NE(refusal(afterGood(timed<openvdb::FloatGrid>(openvdb::FloatGrid::create(bad), 1)))
                  .find("background that is not finite"),
              std::string::npos);
  }
}

TEST_F(VdbFrames, RefusesAnInsideWithoutBounds) {
  EXPECT_EQ(refusal(afterGood(timed<openvdb::FloatGrid>(openvdb::FloatGrid::create(-3), 1))),
            "frame2.vdb: grid '[0]': its background -3 is inside: the solid would have no bounds");
  auto bools = openvdb::BoolGrid::create(true);
  EXPECT_NE(refusal({write("b.vdb", {bools, bools->deepCopyGrid()})}, {.frameTime = 1})
                .find("its background is true"),
            std::string::npos);
}

TEST_F(VdbFrames, RefusesAnIsoValueThatNothingCrosses) {
  auto fog = openvdb::FloatGrid::create(0);
  fog->tree().setValueOn({3, 3, 3}, 0.5F);
  fog->setGridClass(openvdb::GRID_FOG_VOLUME);
  fog->setName("smoke");
  const auto path = write("a.vdb", {fog, fog->deepCopyGrid()});
  EXPECT_EQ(refusal({path}, {.iso = 0.75, .frameTime = 1}),
            "a.vdb: no sample of any frame is above the iso value 0.75");
  EXPECT_EQ(refusal({path}, {.iso = -1, .frameTime = 1}),
            "a.vdb: grid 'smoke[0]': its background 0 is inside: the solid would have no bounds "
            "(the iso value is -1)");
  EXPECT_EQ(refusal({path}, {.iso = NAN, .frameTime = 1}), "the iso value is nan");
  EXPECT_EQ(refusal({path}, {.frameTime = 1}),
            "a.vdb: grid 'smoke[0]': is a fog volume (densities), not a level set: it needs an iso "
            "value");
  EXPECT_EQ(refusal({path}, {.iso = 0.25, .frameTime = 1}), "(was accepted)");
  auto masks = openvdb::MaskGrid::create();
  EXPECT_NE(refusal({write("b.vdb", {masks, masks->deepCopyGrid()})}, {.iso = 1, .frameTime = 1})
                .find("an iso value is given, but a grid of type mask has no values"),
            std::string::npos);
  EXPECT_EQ(refusal({folder_ / "b.vdb"}, {.frameTime = 1}),
            "b.vdb: no sample of any frame is inside");
}

TEST_F(VdbFrames, DensitiesNeedAnIsoValueWithOrWithoutAClass) {
  const auto remedyFor = [&](openvdb::GridClass gridClass) {
    auto grid = openvdb::FloatGrid::create(0);
    grid->tree().setValueOn({3, 3, 3}, 0.5F);
    grid->setGridClass(gridClass);
    return errorOf({write("a.vdb", {grid, grid->deepCopyGrid()})}, {.frameTime = 1})->remedy;
  };
  EXPECT_EQ(remedyFor(openvdb::GRID_FOG_VOLUME), Remedy::IsoValue);
  EXPECT_EQ(remedyFor(openvdb::GRID_UNKNOWN), Remedy::IsoValue);
  EXPECT_EQ(remedyFor(openvdb::GRID_LEVEL_SET), Remedy::None);
}

TEST_F(VdbFrames, OneFileOfSeveralQuantitiesNeedsAName) {
  auto velocity = openvdb::Vec3SGrid::create();
  velocity->setName("velocity");
  timed<openvdb::Vec3SGrid>(velocity, 0);
  const auto path = write("a.vdb", {sphereAt(0), sphereAt(1), velocity});
  EXPECT_EQ(errorOf({path})->remedy, Remedy::GridName);
  EXPECT_FALSE(errorOf({path}, {.grid = "ball"}));
}

TEST_F(VdbFrames, RefusesPointsTooFarFromTheOrigin) {
  auto grid = sphereAt(1);
  grid->tree().setValueOn({2'000'000'000, 0, 0}, -1);
  EXPECT_EQ(refusal(afterGood(grid)),
            "frame2.vdb: grid 'ball': reaches the voxel (2000000000, 0, 0); coordinates must be "
            "below 268435456");
}

}  // namespace
}  // namespace t4d::voxel4d
