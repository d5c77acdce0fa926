#include <cmath>
#include <fstream>
#include <limits>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "model/parallel.h"
#include "platform/test_folder.h"
#include "t4d/frames.h"
#include "t4d/weave.h"
#include "voxel4d/frame_spacing.h"

namespace t4d::voxel4d {
namespace {

using model::Point3;
using model::TriangleMesh;

model::Motion translations(int count) {
  model::ScrewRun run{1, {}, static_cast<std::uint64_t>(count)};
  run.screw.translation = {0, 0, 1};
  return *model::chainScrews(0, std::vector{run});
}

model::Motion turnAbout(const Eigen::Vector3d& axis, double degrees) {
  model::ScrewRun run{2, {}, 1};
  run.screw.axisDirection = axis.normalized();
  run.screw.angleDegrees = degrees;
  run.screw.translation = {3, 0.4, -5};
  return *model::chainScrews(0, std::vector{run});
}

/// Volume of a level set by the smoothed step over one voxel.
double volumeOf(const Frame& frame, double h) {
  const auto part = [&](double value) { return std::clamp(0.5 - value / h, 0.0, 1.0); };
  double points = 0;
  for (const Block& block : frame.blocks) {
    for (unsigned i = 0; i < 512; ++i) points += part(block.values.at(i));
  }
  for (const InsideTile& tile : frame.tiles) points += 512.0 * std::pow(tile.size, 3);
  return points * h * h * h;
}

std::string errorOf(const TriangleMesh& mesh, const VoxelizeOptions& options) {
  const auto frames = voxelFrames(movingSolid(mesh, translations(1)), {0, 1}, options);
  const auto frame = frames->frame(0);
  return frame ? "(was accepted)" : frame.error().text();
}

TEST(Voxelize, PaperCubeIsNineteenPointsWideInEachFrame) {
  const auto times = model::evenTimes({0, 63}, 64);
  for (int i = 0; i < 64; ++i) EXPECT_EQ(times[i], i);
  const auto frames = voxelFrames(movingSolid(fixtures::paperCube(20), translations(63)), times,
                                  {.voxelSize = 1, .mask = true});
  ASSERT_EQ(frames->frameCount(), 64U);
  EXPECT_EQ(frames->lattice(), Lattice{});
  for (std::size_t i = 0; i < 64; ++i) {
    const auto frame = frames->frame(i);
    ASSERT_TRUE(frame) << frame.error().text();
    EXPECT_EQ(frame->time, i);
    EXPECT_EQ(countInside(*frame), 6859U) << i;
  }
}

TEST(Voxelize, LevelSetsHaveTheVolumeOfTheMesh) {
  const auto motion = turnAbout({1, 2, -2}, 100);
  for (const auto& solid : fixtures::allSolids()) {
    const double h = 0.5;
    const auto frames = voxelFrames(movingSolid(solid.mesh, motion), {0, 0.7, 2}, {.voxelSize = h});
    const double volume = signedVolume(solid.mesh);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto frame = frames->frame(i);
      ASSERT_TRUE(frame) << frame.error().text();
      EXPECT_NEAR(frame->outsideValue, 3 * h, 1e-6);
      // Cavities too: the signs are those of the mask.
      EXPECT_NEAR(volumeOf(*frame, h), volume, 0.04 * surfaceArea(solid.mesh) * h)
          << solid.name << " frame " << i;
    }
  }
}

TEST(Voxelize, LevelSetsAreDistancesInTheirBand) {
  const double h = 0.5;
  const auto frames =
      voxelFrames(movingSolid(fixtures::cube(10), translations(1)), {0.3, 1}, {.voxelSize = h});
  const auto frame = frames->frame(0);
  ASSERT_TRUE(frame);
  const Point3 centre(0, 0, 0.3);
  for (const Block& block : frame->blocks) {
    for (unsigned i = 0; i < 512; ++i) {
      const Point3 p = h * Point3(8.0 * block.coord.x + i / 64, 8.0 * block.coord.y + i / 8 % 8,
                                  8.0 * block.coord.z + i % 8);
      const Point3 beyond = (p - centre).cwiseAbs() - Point3::Constant(5);
      const double distance = beyond.cwiseMax(0).norm() + std::min(0.0, beyond.maxCoeff());
      if (std::abs(distance) < 2 * h) {
        ASSERT_NEAR(block.values.at(i), distance, 1e-5) << p.transpose();
      } else {
        // The band may be one voxel narrower at corners.
        ASSERT_GE(std::abs(block.values.at(i)), 2 * h - 1e-5) << p.transpose();
        ASSERT_LE(std::abs(block.values.at(i)), 3 * h + 1e-5) << p.transpose();
      }
      ASSERT_EQ((block.inside[i / 64] >> (i % 64) & 1) != 0, block.values.at(i) < 0);
    }
  }
}

TEST(Voxelize, SignsOfLevelSetAndMaskAreTheSame) {
  const auto motion = turnAbout({0, 1, 1}, 70);
  for (const auto& solid : fixtures::allSolids()) {
    for (const double time : {0.0, 1.1}) {
      const auto count = [&](bool mask) {
        return countInside(
            *voxelFrames(movingSolid(solid.mesh, motion), {time, 2}, {0.6, mask})->frame(0));
      };
      EXPECT_EQ(count(false), count(true)) << solid.name;
    }
  }
}

TEST(Voxelize, IsTheSameForAnyNumberOfThreads) {
  const auto solid = movingSolid(fixtures::boltWithThread(), turnAbout({1, 1, 1}, 40));
  const auto run = [&](std::size_t threads) {
    const model::ThreadLimit limit(threads);
    return *voxelFrames(solid, {0.5, 1}, {.voxelSize = 0.4})->frame(0);
  };
  const Frame one = run(1);
  const Frame many = run(8);
  ASSERT_EQ(one.blocks.size(), many.blocks.size());
  ASSERT_EQ(one.tiles.size(), many.tiles.size());
  for (std::size_t i = 0; i < one.blocks.size(); ++i) {
    ASSERT_EQ(one.blocks[i].coord, many.blocks[i].coord);
    for (unsigned j = 0; j < 512; ++j) {
      ASSERT_EQ(one.blocks[i].values.at(j), many.blocks[i].values.at(j));
    }
  }
}

TEST(Voxelize, FilesAreTheFrames) {
  for (const bool mask : {false, true}) {
    const platform::TestFolder folder;
    const auto solid = movingSolid(fixtures::hollowCube(12, 6), turnAbout({1, 0, 2}, 30));
    const VoxelizeOptions options{.voxelSize = 0.5, .mask = mask};
    const auto times = model::evenTimes({0, 2}, 5);
    const auto written = writeVoxelFrames(solid, times, options, folder / "made/of/folders");
    ASSERT_TRUE(written) << written.error().text();
    EXPECT_EQ(written->frames, 5U);
    ASSERT_EQ(written->files.size(), 5U);
    std::uint64_t bytes = 0;
    for (const VoxelSeries::File& file : written->files) {
      EXPECT_EQ(file.bytes, std::filesystem::file_size(folder / "made/of/folders" / file.name));
      bytes += file.bytes;
    }
    EXPECT_EQ(written->files.back().name, "frame_0004.vdb");
    EXPECT_EQ(written->bytes, bytes);
    const auto source = openVdbFrames(std::vector{folder / "made/of/folders"});
    ASSERT_TRUE(source) << source.error().text();
    ASSERT_EQ((*source)->frameCount(), 5U);
    EXPECT_EQ((*source)->lattice(), (Lattice{0.5, Point3::Zero()}));
    const auto direct = voxelFrames(solid, times, options);
    std::uint64_t inside = 0;
    for (std::size_t i = 0; i < 5; ++i) {
      const auto expected = direct->frame(i);
      const auto found = (*source)->frame(i);
      ASSERT_TRUE(found) << found.error().text();
      EXPECT_EQ(found->time, times[i]);
      EXPECT_EQ(countInside(*found), countInside(*expected));
      ASSERT_EQ(found->blocks.size(), expected->blocks.size());
      for (std::size_t b = 0; b < found->blocks.size(); ++b) {
        EXPECT_EQ(found->blocks[b].inside, expected->blocks[b].inside);
        if (mask) continue;
        for (unsigned j = 0; j < 512; ++j) {
          ASSERT_EQ(found->blocks[b].values.at(j), expected->blocks[b].values.at(j));
        }
      }
      inside += countInside(*found);
    }
    EXPECT_EQ(written->insidePoints, inside);
  }
}

TEST(Voxelize, SolidMayVanishAndComeBack) {
  const platform::TestFolder folder;
  const SolidAtTime solid = [](double time) -> Result<TriangleMesh> {
    return time == 1 ? TriangleMesh{} : fixtures::cube(8);
  };
  ASSERT_TRUE(writeVoxelFrames(solid, {0, 1, 2}, {}, folder / "out"));
  const auto source = openVdbFrames(std::vector{folder / "out"});
  ASSERT_TRUE(source) << source.error().text();
  EXPECT_EQ(countInside(*(*source)->frame(0)), 343U);
  EXPECT_EQ(countInside(*(*source)->frame(1)), 0U);
  EXPECT_EQ(countInside(*(*source)->frame(2)), 343U);
}

TEST(Voxelize, SeriesAppearsWholeOrNotAtAll) {
  const platform::TestFolder folder;
  const SolidAtTime failing = [](double time) -> Result<TriangleMesh> {
    if (time == 2) return invalid("gone");
    return fixtures::cube(8);
  };
  EXPECT_FALSE(writeVoxelFrames(failing, {0, 1, 2}, {}, folder / "out"));
  EXPECT_TRUE(folder.names().empty());

  const auto good = movingSolid(fixtures::cube(8), translations(2));
  ASSERT_TRUE(writeVoxelFrames(good, {0, 1}, {}, folder.path()));
  EXPECT_EQ(folder.names(), (std::vector<std::string>{"frame_0000.vdb", "frame_0001.vdb"}));
  EXPECT_FALSE(writeVoxelFrames(failing, {0, 1, 2}, {}, folder.path()));
  EXPECT_EQ(folder.names(), (std::vector<std::string>{"frame_0000.vdb", "frame_0001.vdb"}));
  ASSERT_TRUE(writeVoxelFrames(good, {0, 1, 2}, {}, folder.path()));
  // Fewer frames than the folder has would leave old ones among the new.
  const auto refuse = [] { return Result<void>(invalid("no")); };
  EXPECT_FALSE(writeVoxelFrames(good, {0, 1, 2}, {}, folder / "refused", {}, refuse));
  EXPECT_FALSE(std::filesystem::exists(folder / "refused"));
  const auto fewer = writeVoxelFrames(good, {0, 1}, {}, folder.path());
  ASSERT_FALSE(fewer);
  EXPECT_NE(fewer.error().text().find("other .vdb files (frame_0002.vdb)"), std::string::npos)
      << fewer.error().text();
  std::ofstream(folder / "file") << "";
  const auto file = writeVoxelFrames(good, {0, 1}, {}, folder / "file");
  ASSERT_FALSE(file);
  EXPECT_NE(file.error().text().find("is not a folder"), std::string::npos);
}

TEST(Voxelize, FrameTimesAreEvenOrStepped) {
  EXPECT_EQ(*frameTimes({-1, 1}, {.count = 5}), (std::vector<double>{-1, -0.5, 0, 0.5, 1}));
  EXPECT_EQ(*frameTimes({0, 1}, {.step = 0.5}), (std::vector<double>{0, 0.5, 1}));
  EXPECT_EQ(*frameTimes({0, 1}, {.step = 0.4}), (std::vector<double>{0, 0.4, 0.8}));
  EXPECT_EQ(*frameTimes({0, 1}, {.step = 0.1}),
            (std::vector<double>{0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1}));
  EXPECT_EQ(*frameTimes({0, 1}, {.count = 4, .step = 0.1}),
            (std::vector<double>{0, 0.1, 0.2, 0.3}));
  // A step that was rounded up still reaches the end.
  EXPECT_EQ(*frameTimes({0, 1}, {.step = 0.33333333334}),
            (std::vector<double>{0, 0.33333333334, 0.66666666668, 1}));
}

TEST(Voxelize, FrameTimesOutOfReachAreRefused) {
  const auto refusalOf = [](const model::TimeSpan& span, const FrameTimes& when) {
    const auto times = frameTimes(span, when);
    return times ? "(was accepted)" : times.error().message;
  };
  EXPECT_EQ(refusalOf({0, 1}, {.count = 1}), "1 frames; a series needs two or more");
  EXPECT_EQ(refusalOf({0, 1}, {.count = 2'000'000}), "2000000 frames; at most 1000000 are allowed");
  EXPECT_NE(refusalOf({0, 1}, {.step = 1e-9}).find("at most 1000000 are allowed"),
            std::string::npos);
  EXPECT_EQ(refusalOf({0, 1}, {.step = 2}),
            "the time between frames is 2, but from 0 to 1 there is only 1");
  EXPECT_EQ(refusalOf({0, 1}, {.count = 4, .step = 0.5}),
            "4 frames are requested, 0.5 apart; from 0 to 1 there can be 2 to 3");
  for (const double step : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_NE(refusalOf({0, 1}, {.step = step}).find("must be a positive number"),
              std::string::npos);
  }
  for (const FrameTimes& when : {FrameTimes{.count = 100}, FrameTimes{.step = 0.01}}) {
    EXPECT_NE(refusalOf({1e15, 1e15 + 1}, when).find("too close to be told apart"),
              std::string::npos);
  }
}

TEST(Voxelize, ASolidOfWholeBlocksIsWrittenHoweverManyFacesItHas) {
  // Every point is in a tile, of which there are more than can be woven.
  TriangleMesh plate = fixtures::cube(1);
  for (Point3& vertex : plate.vertices) {
    vertex = (vertex.array() < 0).select(Point3::Constant(-0.5), Point3(1607.5, 1607.5, 7.5));
  }
  const platform::TestFolder folder;
  const auto written = writeVoxelFrames([&](double) { return plate; }, {0, 1},
                                        {.voxelSize = 1, .mask = true}, folder / "frames");
  ASSERT_TRUE(written) << written.error().text();
  EXPECT_EQ(written->insidePoints, 2U * 1608 * 1608 * 8);
  EXPECT_EQ(written->partsLost.count, 0U);
}

TEST(Voxelize, LevelSetsAreTheSameFarFromTheOrigin) {
  const auto wovenAt = [](double offset) {
    TriangleMesh mesh = fixtures::cube(10.5);
    for (model::Point3& vertex : mesh.vertices) vertex.x() += offset;
    const auto frames = voxelFrames([&](double) { return Result<TriangleMesh>(mesh); }, {0, 1}, {});
    model::Mesh woven;
    EXPECT_TRUE(weave(*frames, {}, woven));
    return woven;
  };
  const model::Mesh here = wovenAt(0);
  for (const int exponent : {12, 17, 20, 25, 27}) {
    const double offset = std::ldexp(1.0, exponent);
    const model::Mesh there = wovenAt(offset);
    ASSERT_EQ(there.slabs().size(), here.slabs().size());
    for (std::size_t i = 0; i < here.slabs().size(); ++i) {
      const auto& expected = here.slabs()[i].vertices;
      const auto& found = there.slabs()[i].vertices;
      ASSERT_EQ(found.size(), expected.size()) << exponent;
      for (std::size_t k = 0; k < found.size(); ++k) {
        const model::Point4 back = found[k] - offset * model::Point4::UnitX();
        EXPECT_LT((back - expected[k]).norm(), 1e-5) << exponent;
      }
    }
  }
}

/// A box as one component of a mesh.
void addBox(TriangleMesh& mesh, const Point3& low, const Point3& high) {
  const TriangleMesh box = fixtures::cube(1);
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const Point3& corner : box.vertices) {
    mesh.vertices.emplace_back((corner.array() < 0).select(low, high));
  }
  for (const auto& [a, b, c] : box.triangles) {
    mesh.triangles.push_back({first + a, first + b, first + c});
  }
}

TEST(Voxelize, PartsThatOverlapOrTouchAreTheirUnion) {
  TriangleMesh whole;
  addBox(whole, {0.5, 0, 0}, {2, 1, 1});
  std::vector<TriangleMesh> parted(5);
  // Overlapping; touching; one within the other, with common faces and without; with other corners.
  addBox(parted[0], {0.5, 0, 0}, {1.5, 1, 1});
  addBox(parted[0], {1, 0, 0}, {2, 1, 1});
  addBox(parted[1], {0.5, 0, 0}, {1.2, 1, 1});
  addBox(parted[1], {1.2, 0, 0}, {2, 1, 1});
  parted[2] = whole;
  addBox(parted[2], {1, 0, 0.2}, {1.6, 0.5, 1});
  parted[3] = whole;
  addBox(parted[3], {0.8, 0.2, 0.2}, {1.5, 0.8, 0.7});
  addBox(parted[4], {0.5, 0, 0}, {1.7, 0.6, 1});
  addBox(parted[4], {0.5, 0.3, 0}, {2, 1, 1});
  addBox(parted[4], {1, 0, 0}, {2, 0.4, 1});
  for (std::size_t i = 0; i < parted.size(); ++i) {
    for (const double shift : {0.0, 0.037}) {
      model::ScrewRun run{1, {}, 1};
      run.screw.translation = {0.3, 0.15, 0};
      model::Motion motion = *model::chainScrews(0, std::vector{run});
      const auto framesOf = [&](TriangleMesh mesh, bool mask) {
        for (Point3& vertex : mesh.vertices) vertex.array() += shift;
        return voxelFrames(movingSolid(std::move(mesh), motion), {0, 0.5, 1}, {0.1, mask});
      };
      for (const bool mask : {false, true}) {
        SCOPED_TRACE(std::to_string(i) + (mask ? " mask " : " ") + std::to_string(shift));
        const auto expected = framesOf(whole, mask);
        const auto found = framesOf(parted[i], mask);
        for (std::size_t k = 0; k < 3; ++k) {
          const auto a = expected->frame(k);
          const auto b = found->frame(k);
          ASSERT_TRUE(a && b) << b.error().text();
          ASSERT_EQ(countInside(*a), countInside(*b));
          ASSERT_EQ(a->tiles.size(), b->tiles.size());
          ASSERT_EQ(a->blocks.size(), b->blocks.size());
          for (std::size_t block = 0; block < a->blocks.size(); ++block) {
            ASSERT_EQ(a->blocks[block].coord, b->blocks[block].coord);
            ASSERT_EQ(a->blocks[block].inside, b->blocks[block].inside);
            for (unsigned j = 0; j < 512 && !mask; ++j) {
              const double distance = a->blocks[block].values.at(j);
              // Farther away, OpenVDB's distances depend on how faces are divided.
              if (std::abs(distance) > 0.1) continue;
              ASSERT_NEAR(b->blocks[block].values.at(j), distance, 1e-7);
            }
          }
        }
      }
    }
  }
}

TEST(Voxelize, ErrorsNameTheFrame) {
  const SolidAtTime failing = [](double time) -> Result<TriangleMesh> {
    TriangleMesh mesh = fixtures::cube(4);
    if (time == 1) mesh.triangles.pop_back();
    return mesh;
  };
  const auto frames = voxelFrames(failing, {0, 1}, {.places = {Place("a.stl"), Place("b.stl")}});
  EXPECT_EQ(frames->placeOf(1).text(), "b.stl");
  ASSERT_TRUE(frames->frame(0));
  const auto frame = frames->frame(1);
  ASSERT_FALSE(frame);
  EXPECT_EQ(frame.error().text().substr(0, 32), "b.stl: at time 1: the mesh is op");
}

TEST(Voxelize, ErrorsSayWhen) {
  EXPECT_EQ(errorOf(fixtures::cube(4), {.voxelSize = 0}),
            "voxels of 0 are requested; 1e-30 to 1e+30 are possible");
  TriangleMesh open = fixtures::cube(4);
  open.triangles.pop_back();
  EXPECT_NE(errorOf(open, {}).find("at time 0: the mesh is open"), std::string::npos);
  EXPECT_NE(errorOf(fixtures::cube(4), {.voxelSize = 1e-5}).find("use larger voxels"),
            std::string::npos);
}

}  // namespace
}  // namespace t4d::voxel4d
