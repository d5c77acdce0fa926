#include <cmath>
#include <memory>
#include <numbers>

#include <gtest/gtest.h>

#include "t4d/check.h"
#include "t4d/frames.h"
#include "t4d/weave.h"
#include "voxel4d/sampled_frames.h"

namespace t4d::voxel4d {
namespace {

/// Not cubes of 8 points, so that blocks at the far sides are not full.
constexpr std::array<std::size_t, 3> kSize = {21, 18, 19};
const Lattice kLattice = {0.5, {-1, 2, 0.25}};

double ballDistance(const model::Point3& point, double time) {
  return (point - model::Point3(4 + time, 6.5, 4.75)).norm() - 3.2;
}

/// The ball's values at three times, as `of(distance)`.
template <class T, class Of>
struct Ball {
  std::array<std::unique_ptr<T[]>, 3> memory;
  std::vector<ArrayFrame<T>> frames;

  explicit Ball(Of of) {
    constexpr std::size_t kCount = kSize[0] * kSize[1] * kSize[2];
    for (std::size_t f = 0; f < memory.size(); ++f) {
      memory[f] = std::make_unique<T[]>(kCount);
      const double time = 0.25 * static_cast<double>(f);
      std::size_t i = 0;
      for (std::size_t x = 0; x < kSize[0]; ++x) {
        for (std::size_t y = 0; y < kSize[1]; ++y) {
          for (std::size_t z = 0; z < kSize[2]; ++z) {
            const Eigen::Vector3d point(static_cast<double>(x), static_cast<double>(y),
                                        static_cast<double>(z));
            memory[f][i++] = of(ballDistance(kLattice(point), time));
          }
        }
      }
      frames.push_back({time, {memory[f].get(), kCount}});
    }
  }
};

template <class T>
auto ball(auto of) {
  return Ball<T, decltype(of)>(of);
}

model::Mesh woven(Result<std::unique_ptr<FrameSource>> frames) {
  model::Mesh mesh;
  EXPECT_TRUE(frames) << frames.error().text();
  if (!frames) return mesh;
  const auto report = weave(**frames, {}, mesh);
  EXPECT_TRUE(report) << report.error().text();
  return mesh;
}

void expectSame(const model::Mesh& a, const model::Mesh& b) {
  ASSERT_EQ(a.slabCount(), b.slabCount());
  for (std::size_t i = 0; i < a.slabCount(); ++i) {
    EXPECT_EQ(a.slabs()[i].vertices, b.slabs()[i].vertices);
    EXPECT_EQ(*a.slabs()[i].connectivity, *b.slabs()[i].connectivity);
  }
}

TEST(ArrayFrames, WeaveAsTheSameFieldSampledDoes) {
  model::Bounds3 box;
  box.add(kLattice(Eigen::Vector3d::Zero()));
  box.add(kLattice(Eigen::Vector3d(kSize[0] - 1.0, kSize[1] - 1.0, kSize[2] - 1.0)));
  const auto doubles = ball<double>([](double distance) { return distance; });
  const auto sampled = sampledFrames(ballDistance, kLattice, box, {0, 0.25, 0.5}, {.band = 100});
  const auto mesh = woven(arrayFrames<double>(doubles.frames, {kSize, kLattice}));
  model::Mesh expected;
  ASSERT_TRUE(weave(*sampled, {}, expected));
  expectSame(mesh, expected);
  const auto report = measure::checkMesh(mesh);
  ASSERT_TRUE(report && report->valid());
  EXPECT_NEAR(report->hypervolume, 0.5 * 4 / 3 * std::numbers::pi * std::pow(3.2, 3), 1.5);
}

TEST(ArrayFrames, TakeDensitiesAboveAnIsoValueAndBools) {
  const auto floats = ball<float>([](double d) { return static_cast<float>(d); });
  const auto densities = ball<float>([](double d) { return 0.5F - static_cast<float>(d); });
  const auto bools = ball<bool>([](double d) { return d < 0; });
  const auto mesh = woven(arrayFrames<float>(floats.frames, {kSize, kLattice}));
  const auto dense = woven(arrayFrames<float>(densities.frames, {kSize, kLattice, 0.5}));
  const auto mask = woven(arrayFrames<bool>(bools.frames, {kSize, kLattice}));
  ASSERT_EQ(dense.slabCount(), mesh.slabCount());
  ASSERT_EQ(mask.slabCount(), mesh.slabCount());
  for (std::size_t i = 0; i < mesh.slabCount(); ++i) {
    // The same points are inside, so the same cells are made; bools put vertices at midpoints.
    EXPECT_EQ(*dense.slabs()[i].connectivity, *mesh.slabs()[i].connectivity);
    EXPECT_EQ(*mask.slabs()[i].connectivity, *mesh.slabs()[i].connectivity);
  }
}

TEST(ArrayFrames, CloseASolidThatFillsItsArray) {
  const std::unique_ptr<bool[]> all(new bool[64]);
  std::fill_n(all.get(), 64, true);
  const std::span<const bool> values(all.get(), 64);
  const std::vector<ArrayFrame<bool>> frames = {{0, values}, {2, values}};
  const auto mesh = woven(arrayFrames<bool>(frames, {{4, 4, 4}, {}}));
  const auto report = measure::checkMesh(mesh);
  ASSERT_TRUE(report && report->valid());
  EXPECT_EQ(report->bounds.min, model::Point4(-0.5, -0.5, -0.5, 0));
  EXPECT_EQ(report->bounds.max, model::Point4(3.5, 3.5, 3.5, 2));
}

TEST(ArrayFrames, SayWhatIsWrongWithTheirInput) {
  std::vector<float> values(8, -1);
  const auto faultOf = [&](const ArrayOptions& options) {
    const std::vector<ArrayFrame<float>> frames = {{0, values}};
    const auto made = arrayFrames<float>(frames, options);
    return made ? std::string() : made.error().text();
  };
  EXPECT_EQ(faultOf({{2, 2, 2}, {}}), "");
  EXPECT_EQ(faultOf({{2, 0, 2}, {}}), "the size of the arrays is 2 x 0 x 2");
  EXPECT_EQ(faultOf({{2, 3, 4}, {}}),
            "frame 0: the array has 8 values where 2 x 3 x 4 = 24 are expected");
  EXPECT_EQ(faultOf({{2, 2, 2}, {0, {0, 0, 0}}}),
            "voxels of 0 are requested; 1e-30 to 1e+30 are possible");
  EXPECT_EQ(faultOf({{2, 2, 2}, {1, {0, INFINITY, 0}}}),
            "the origin is (0, inf, 0); it must be finite");
  EXPECT_EQ(faultOf({{2, 2, 2}, {}, 1e30}), "");
  values = std::vector<float>(8, 1e30F);
  EXPECT_EQ(faultOf({{2, 2, 2}, {}, 1e30 + 1e15}),
            "the values differ from the iso value "
            "1.000000000000001e+30 by too little");
  values[5] = std::numeric_limits<float>::infinity();
  EXPECT_EQ(faultOf({{2, 2, 2}, {}}), "frame 0: the value at (1, 0, 1) is inf");
}

}  // namespace
}  // namespace t4d::voxel4d
