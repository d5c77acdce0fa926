#include "t4d/weave.h"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include "model/parallel.h"
#include "t4d/check.h"
#include "t4d/mesh.h"
#include "voxel4d/frame_layer.h"
#include "voxel4d/sampled_frames.h"

namespace t4d::voxel4d {
namespace {

using model::Point3;

using Field = std::function<double(int x, int y, int z, int frame)>;

/// Frames of a box of lattice points from (0, 0, 0) to size - 1, negative inside; outside
/// elsewhere.
class BoxFrames : public FrameSource {
 public:
  BoxFrames(Coord size, std::size_t frames, Field field, bool values)
      : size_(size), frames_(frames), field_(std::move(field)), values_(values) {}

  const Lattice& lattice() const override { return lattice_; }
  std::size_t frameCount() const override { return frames_; }
  Result<Frame> frame(std::size_t index) override {
    Frame frame;
    frame.time = static_cast<double>(index);
    frame.outsideValue = values_ ? 1 : 0;
    auto memory = std::make_shared<std::vector<std::array<double, 512>>>();
    const auto blocks = [](int n) { return (n + 7) / 8; };
    memory->reserve(static_cast<std::size_t>(blocks(size_.x)) * blocks(size_.y) * blocks(size_.z));
    for (int bx = 0; bx < blocks(size_.x); ++bx) {
      for (int by = 0; by < blocks(size_.y); ++by) {
        for (int bz = 0; bz < blocks(size_.z); ++bz) {
          auto& values = memory->emplace_back();
          Block block{{bx, by, bz}, {}, {}};
          int inside = 0;
          for (unsigned i = 0; i < 512; ++i) {
            const int x = 8 * bx + static_cast<int>(i >> 6U);
            const int y = 8 * by + static_cast<int>(i >> 3U & 7U);
            const int z = 8 * bz + static_cast<int>(i & 7U);
            const bool within = x < size_.x && y < size_.y && z < size_.z;
            values[i] = within ? field_(x, y, z, static_cast<int>(index)) : 1;
            if (values[i] < 0) {
              block.inside[i >> 6U] |= std::uint64_t{1} << (i & 63U);
              ++inside;
            }
          }
          if (inside == 0) continue;
          if (inside == 512 && useTiles) {
            frame.tiles.push_back({block.coord, 1, values_ ? -1.0 : 0});
            continue;
          }
          if (values_) block.values.doubles = values.data();
          frame.blocks.push_back(block);
        }
      }
    }
    frame.owner = memory;
    return frame;
  }

  bool useTiles = true;

 private:
  Coord size_;
  std::size_t frames_;
  Field field_;
  bool values_;
  Lattice lattice_;
};

struct Woven {
  WeaveReport report;
  model::Mesh mesh;
  measure::MeshReport judged;
};

Woven woven(FrameSource& frames, const WeaveOptions& options = {}, bool links = true) {
  Woven result;
  const auto report = weave(frames, options, result.mesh);
  EXPECT_TRUE(report) << report.error().text();
  if (report) result.report = *report;
  const auto judged = measure::checkMesh(result.mesh, {.vertexLinks = links});
  EXPECT_TRUE(judged) << judged.error().text();
  if (judged) result.judged = *judged;
  EXPECT_EQ(result.judged.vertices, result.report.vertices);
  EXPECT_EQ(result.judged.tetrahedra, result.report.tetrahedra);
  return result;
}

void expectSound(const Woven& result) {
  EXPECT_TRUE(result.judged.closed && result.judged.oriented);
  EXPECT_TRUE(result.judged.vertexLinksOk.value_or(true));
  EXPECT_EQ(result.judged.issues.errors, 0U) << result.judged.issues.issues.front().code << ": "
                                             << result.judged.issues.issues.front().message;
  EXPECT_EQ(result.judged.degenerateCells, 0U);
}

TEST(Weave, RandomLatticesAreClosedOrientedManifolds) {
  const Coord sizes[] = {{1, 1, 1}, {2, 3, 4}, {9, 9, 9}, {17, 8, 10}};
  for (const Coord& size : sizes) {
    for (unsigned seed = 1; seed <= 6; ++seed) {
      SCOPED_TRACE(testing::Message() << size.x << " seed " << seed);
      const auto toss = [&](int x, int y, int z, int frame) {
        std::mt19937 random(seed * 7919 + ((x * 64 + y) * 64 + z) * 64 + frame);
        random.discard(4);
        return std::uniform_real_distribution<double>(-1, seed % 2 == 0 ? 1 : 3)(random);
      };
      for (const bool values : {false, true}) {
        for (const CapStyle caps : {CapStyle::Flat, CapStyle::HalfStep}) {
          BoxFrames frames(size, 4, toss, values);
          Woven result;
          const auto report = weave(frames, {.caps = caps}, result.mesh);
          if (!report) continue;  // all outside by chance
          result.report = *report;
          result.judged = *measure::checkMesh(result.mesh, {.vertexLinks = true});
          expectSound(result);
        }
      }
    }
  }
}

void expectSameMesh(const Woven& a, const Woven& b) {
  ASSERT_EQ(a.mesh.slabCount(), b.mesh.slabCount());
  for (std::size_t i = 0; i < a.mesh.slabCount(); ++i) {
    EXPECT_EQ(a.mesh.slabs()[i].vertices, b.mesh.slabs()[i].vertices);
    EXPECT_EQ(a.mesh.slabs()[i].connectivity->cells, b.mesh.slabs()[i].connectivity->cells);
  }
}

/// Every vertex is where the field, linear along its edge of the lattice, in space or in time, is
/// zero.
TEST(Weave, VerticesAreWhereTheFieldIsZero) {
  const Coord size = {10, 9, 8};
  // Far enough from zero that no crossing is moved off a lattice point.
  const auto field = [](int x, int y, int z, int frame) {
    std::mt19937 random(((x * 64 + y) * 64 + z) * 64 + frame);
    random.discard(4);
    const double value = std::uniform_real_distribution<double>(0.1, 1)(random);
    return random() % 2 == 0 ? value : -value;
  };
  BoxFrames frames(size, 3, field, true);
  const Woven result = woven(frames, {}, false);
  for (const model::Slab& slab : result.mesh.slabs()) {
    if (slab.timeBegin == slab.timeEnd) continue;  // caps have their vertices moved to the end
    for (const model::Point4& vertex : slab.vertices) {
      const Eigen::Array4i from = vertex.array().floor().cast<int>();
      const Eigen::Array4i to = vertex.array().ceil().cast<int>();
      ASSERT_EQ((to - from).sum(), 1) << vertex.transpose();
      const auto valueAt = [&](const Eigen::Array4i& p) {
        const bool within =
            (p.head<3>() >= 0).all() && p[0] < size.x && p[1] < size.y && p[2] < size.z;
        return within ? field(p[0], p[1], p[2], p[3]) : 1;
      };
      const double s = (vertex.array() - from.cast<double>()).sum();
      EXPECT_NEAR((1 - s) * valueAt(from) + s * valueAt(to), 0, 1e-13) << vertex.transpose();
    }
  }
}

/// Section 5.1: 64 frames of a cube of 19 samples a side (side 20, points on the surface outside),
/// moving by one sample a frame.
TEST(Weave, PaperCubeHasThePapersCounts) {
  const auto cube = [](int x, int y, int z, int frame) {
    const auto within = [](int k) { return k >= 1 && k < 20; };
    return within(x) && within(y) && within(z - frame) ? -1.0 : 1.0;
  };
  BoxFrames frames({21, 21, 84}, 64, cube, false);
  Woven result = woven(frames, {}, false);
  EXPECT_EQ(result.report.vertices, 197828U);
  EXPECT_EQ(result.report.tetrahedra, 1185280U);
  expectSound(result);
}

TEST(Weave, TilesAndBlocksGiveTheSameMesh) {
  const auto cube = [](int x, int y, int z, int frame) {
    const auto within = [](int k) { return k >= 8 && k < 32; };
    return within(x) && within(y) && within(z - 8 * frame) ? -1.0 : 1.0;
  };
  BoxFrames tiles({40, 40, 56}, 4, cube, false);
  BoxFrames blocks({40, 40, 56}, 4, cube, false);
  blocks.useTiles = false;
  Woven a = woven(tiles, {}, false);
  Woven b = woven(blocks, {}, false);
  expectSound(a);
  expectSameMesh(a, b);
}

TEST(Weave, StopsWhenTold) {
  const auto ball = [](int x, int y, int z, int) { return std::hypot(x - 8, y - 8, z - 8) - 5; };
  BoxFrames frames({16, 16, 16}, 9, ball, true);
  std::size_t reports = 0;
  model::Mesh woven;
  const auto report = weave(frames, {}, woven, [&](double) { return ++reports < 3; });
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().message, "stopped");
  EXPECT_EQ(reports, 3U);
}

/// The next frame is read while a slab is put.
TEST(Weave, ASlabThatCannotBePutIsSaidBeforeALaterFrameThatCannotBeRead) {
  struct Cut : BoxFrames {
    using BoxFrames::BoxFrames;
    Result<Frame> frame(std::size_t index) override {
      if (index == 2) return invalid("no frame 2");
      return BoxFrames::frame(index);
    }
  };
  struct Full : model::Sink {
    explicit Full(std::size_t room) : room(room) {}
    Result<void> put(const model::Slab& /*slab*/) override {
      if (room-- > 0) return {};
      return invalid("no room");
    }
    std::size_t room;
  };
  const auto ball = [](int x, int y, int z, int) { return std::hypot(x - 8, y - 8, z - 8) - 5; };
  constexpr std::size_t kBeforeFrame2 = 2;  // a cap, and the slab of frames 0 and 1
  for (const std::size_t threads : {1U, 2U}) {
    const model::ThreadLimit control(threads);
    for (std::size_t room = 0; room <= kBeforeFrame2; ++room) {
      Cut frames({16, 16, 16}, 4, ball, true);
      Full sink(room);
      const auto report = weave(frames, {}, sink);
      ASSERT_FALSE(report);
      EXPECT_EQ(report.error().message, room < kBeforeFrame2 ? "no room" : "no frame 2");
    }
  }
}

TEST(Weave, SameBytesForAnyNumberOfThreads) {
  const auto ball = [](int x, int y, int z, int frame) {
    return std::hypot(x - 20.3, y - 19.1, z - 12 - 2.3 * frame) - 9;
  };
  std::vector<Woven> all;
  for (const std::size_t threads : {1U, 2U, 5U}) {
    const model::ThreadLimit control(threads);
    BoxFrames frames({40, 40, 48}, 5, ball, true);
    all.push_back(woven(frames, {}, false));
  }
  for (const Woven& other : all) expectSameMesh(other, all[0]);
}

/// Large frames keep their values in a temporary file.
TEST(Weave, SameBytesWithValuesInAFile) {
  const auto ball = [](const Point3& p, double t) {
    return (p - Point3(20.3 + 0.7 * t, 19.1, 12)).norm() - 9 - t;
  };
  model::Bounds3 box;
  box.add({0, 0, 0});
  box.add({50, 40, 40});
  for (const bool asFloat : {false, true}) {
    for (const CapStyle caps : {CapStyle::Flat, CapStyle::HalfStep, CapStyle::Graded}) {
      std::vector<Woven> both;
      for (const std::size_t largeFrame :
           {std::numeric_limits<std::size_t>::max(), std::size_t{0}}) {
        const auto frames = sampledFrames(ball, {}, box, {0, 1, 2, 3}, {.asFloat = asFloat});
        both.push_back(woven(*frames, {.caps = caps, .largeFrame = largeFrame}, false));
      }
      expectSameMesh(both[0], both[1]);
    }
  }
}

TEST(Weave, HypervolumeOfAMovingBallConverges) {
  // A ball of radius 1 moving by 1 during time 1, sampled at h and dt = h.
  std::vector<double> errors;
  for (const int n : {8, 16, 32}) {
    const double h = 1.0 / n;
    const auto ball = [&](int x, int y, int z, int frame) {
      return std::hypot(x * h - 1.31, y * h - 1.27, z * h - 1.23 - frame * h) - 1;
    };
    const int size = static_cast<int>(2.7 * n);
    BoxFrames frames({size, size, size + n}, static_cast<std::size_t>(n) + 1, ball, true);
    Woven result = woven(frames, {}, n == 8);
    expectSound(result);
    const double found = result.judged.hypervolume * h * h * h * h;
    errors.push_back(std::abs(found - 4 * std::numbers::pi / 3));
  }
  const double order = std::log2(errors[1] / errors[2]);
  std::cout << "errors " << errors[0] << " " << errors[1] << " " << errors[2] << ", order " << order
            << "\n";
  EXPECT_GT(order, 1.8);
}

TEST(FrameLayer, CrossingsAreNumberedUpToTheLastOf32Bits) {
  CrossingBlock full;
  for (BlockMask& mask : full.edges) mask.fill(kAllBits);
  constexpr std::uint32_t kEdgesOfABlock = 3 * 512;
  EXPECT_EQ(*numberFrom(0, full), kEdgesOfABlock);
  EXPECT_EQ(full.number(2, 7, 63), kEdgesOfABlock - 1);
  const std::uint32_t last = std::numeric_limits<std::uint32_t>::max();
  EXPECT_EQ(*numberFrom(last - kEdgesOfABlock, full), last);
  EXPECT_EQ(full.number(2, 7, 63), last - 1);
  for (const std::uint32_t first : {last - kEdgesOfABlock + 1, last}) {
    const auto past = numberFrom(first, full);
    ASSERT_FALSE(past);
    EXPECT_NE(past.error().message.find("more than 4294967295 edges"), std::string::npos);
  }
}

TEST(Weave, HalfStepCapsAreHalfAStepOutside) {
  const auto cube = [](int x, int, int, int) { return x == 1 ? -1.0 : 1.0; };
  BoxFrames frames({3, 3, 3}, 3, cube, false);
  Woven result = woven(frames, {CapStyle::HalfStep});
  expectSound(result);
  EXPECT_EQ(result.judged.time.begin, -0.5);
  EXPECT_EQ(result.judged.time.end, 2.5);
}

TEST(Weave, ASolidVanishesAndComesBack) {
  const auto blink = [](int, int, int, int frame) { return frame == 1 || frame == 4 ? -1.0 : 1.0; };
  BoxFrames frames({3, 3, 3}, 7, blink, false);
  Woven result = woven(frames);
  expectSound(result);
  EXPECT_EQ(result.judged.components, 2U);
  EXPECT_EQ(result.judged.time.begin, 0);
  EXPECT_EQ(result.judged.time.end, 6);
}

TEST(Weave, TooFewFramesAndNothingInsideAreRefused) {
  model::Mesh mesh;
  const auto solid = [](int, int, int, int) { return -1.0; };
  BoxFrames one({3, 3, 3}, 1, solid, false);
  EXPECT_NE(weave(one, {}, mesh).error().message.find("this one 1"), std::string::npos);
  BoxFrames none({3, 3, 3}, 0, solid, false);
  EXPECT_FALSE(weave(none, {}, mesh));
  BoxFrames empty(
      {3, 3, 3}, 3, [](int, int, int, int) { return 1.0; }, false);
  EXPECT_NE(weave(empty, {}, mesh).error().message.find("no frame has a surface"),
            std::string::npos);
}

/// Two frames of one tile each, of these sizes, next to nothing else; none where the size is 0.
class TileFrames : public FrameSource {
 public:
  TileFrames(std::int32_t first, std::int32_t second) : sizes_{first, second} {}

  const Lattice& lattice() const override { return lattice_; }
  std::size_t frameCount() const override { return 2; }
  Result<Frame> frame(std::size_t index) override {
    Frame frame;
    frame.time = static_cast<double>(index);
    if (sizes_[index] > 0) frame.tiles.push_back({{0, 0, 0}, sizes_[index], 0});
    return frame;
  }

 private:
  std::array<std::int32_t, 2> sizes_;
  Lattice lattice_;
};

TEST(Weave, ATileThatLiesInALargerOneIsNoMoreThanItsBlocks) {
  for (const auto& [first, second] : {std::pair{4, 1}, {1, 4}}) {
    SCOPED_TRACE(testing::Message() << first << " " << second);
    const auto cubes = [&](int x, int y, int z, int frame) {
      const int size = 8 * (frame == 0 ? first : second);
      return x < size && y < size && z < size ? -1.0 : 1.0;
    };
    BoxFrames blocks({32, 32, 32}, 2, cubes, false);
    blocks.useTiles = false;
    TileFrames tiles(first, second);
    Woven byTiles;
    Woven byBlocks;
    ASSERT_TRUE(weave(tiles, {}, byTiles.mesh) && weave(blocks, {}, byBlocks.mesh));
    expectSameMesh(byTiles, byBlocks);
  }
}

TEST(Weave, TilesOfBillionsOfPointsAreRefusedAtOnce) {
  const auto errorOf = [](std::int32_t first, std::int32_t second) {
    TileFrames frames(first, second);
    model::NullSink sink;
    const auto woven = weave(frames, {}, sink);
    return woven ? std::string() : woven.error().text();
  };
  EXPECT_NE(errorOf(512, 512).find("points at the surface lie in tiles"), std::string::npos);
  EXPECT_NE(errorOf(32, 0).find("appear or vanish between two frames"), std::string::npos);
  EXPECT_EQ(errorOf(8, 8), "");
  EXPECT_EQ(errorOf(8, 0), "");
}

/// However a lattice comes to its place, doubles must be fine enough for its voxels there: what is
/// woven is sound, and measures what it measures at the origin; everything else is refused.
TEST(Weave, WhatLiesTooFarFromTheOriginIsRefused) {
  class Placed : public BoxFrames {
   public:
    Placed(const Lattice& lattice)
        : BoxFrames(
              {9, 9, 9}, 2,
              [](int x, int y, int z, int frame) {
                return std::hypot(x - 4 - 0.2 * frame, y - 4.1, z - 3.9) - 2.6;
              },
              true),
          lattice_(lattice) {}
    const Lattice& lattice() const override { return lattice_; }

   private:
    Lattice lattice_;
  };
  Placed atOrigin({1, Point3::Zero()});
  const double expected = woven(atOrigin, {}, false).judged.hypervolume;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> exponent(-20, 20);
  std::normal_distribution<double> normal;
  int sound = 0;
  int refused = 0;
  for (int trial = 0; trial < 300; ++trial) {
    SCOPED_TRACE(trial);
    const double size = std::pow(10, exponent(random));
    const Point3 origin = size * std::pow(10, std::abs(exponent(random))) *
                          Point3(normal(random), normal(random), normal(random));
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    if (trial % 3 == 2) {
      for (double& entry : turn.reshaped()) entry = normal(random);
      if (std::abs(turn.determinant()) < 0.3) continue;
    }
    model::Affine3x4 toSpace;
    toSpace << size * turn, origin;
    Placed frames(trial % 3 == 0 ? Lattice{size, origin} : Lattice{});
    WeaveOptions options;
    if (trial % 3 != 0) options.toSpace = toSpace;
    model::Mesh mesh;
    const auto report = weave(frames, options, mesh);
    const double away = origin.cwiseAbs().maxCoeff() / size;
    if (!report) {
      ++refused;
      EXPECT_GT(away, 1e6);
      EXPECT_EQ(report.error().where.text(), "frame 0");
      EXPECT_NE(report.error().message.find("voxels from the origin of space"), std::string::npos)
          << report.error().message;
      continue;
    }
    ++sound;
    EXPECT_LT(away, 1e9);
    const auto judged = measure::checkMesh(mesh);
    ASSERT_TRUE(judged && judged->closed && judged->oriented);
    const double scale = std::abs((size * turn).determinant());
    EXPECT_NEAR(judged->hypervolume, expected * scale, 1e-5 * expected * scale);
  }
  EXPECT_GT(sound, 50);
  EXPECT_GT(refused, 50);
  for (const double size : {1e-71, 1e71, 0.0, double(NAN), double(INFINITY)}) {
    Placed frames({size, Point3::Zero()});
    model::Mesh mesh;
    EXPECT_FALSE(weave(frames, {}, mesh)) << size;
  }
}

}  // namespace
}  // namespace t4d::voxel4d
