#include "voxel4d/mask_distance.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "t4d/check.h"
#include "t4d/frames.h"
#include "t4d/slice.h"
#include "t4d/weave.h"

namespace t4d::voxel4d {
namespace {

using model::Point3;

/// A cube of lattice points from (0, 0, 0) on.
struct Cube {
  int size = 0;
  std::function<bool(const Eigen::Vector3d& point)> inside;

  bool has(int x, int y, int z) const {
    const auto within = [&](int i) { return i >= 0 && i < size; };
    return within(x) && within(y) && within(z) && inside(Eigen::Vector3d(x, y, z));
  }
  /// Its points, each the sample that `of` makes of whether it is inside.
  template <class T>
  std::vector<T> samples(T in, T out) const {
    std::vector<T> values;
    for (int x = 0; x < size; ++x) {
      for (int y = 0; y < size; ++y) {
        for (int z = 0; z < size; ++z) values.push_back(has(x, y, z) ? in : out);
      }
    }
    return values;
  }
};

std::function<bool(const Eigen::Vector3d&)> ball(const Point3& centre, double radius) {
  return [=](const Eigen::Vector3d& point) { return (point - centre).norm() < radius; };
}

TEST(FaceDistance, IsThatOfTheNearestVoxelOfTheOtherSide) {
  std::mt19937 random(3);
  for (const std::array<double, 3>& edges :
       {std::array{1.0, 1.0, 1.0}, {0.5, 1.25, 3.0}, {2e-9, 1e-9, 1.1e-9}}) {
    for (const double density : {0.5, 0.02, 0.0005}) {
      SCOPED_TRACE(testing::Message() << edges[2] << " " << density);
      constexpr int kSize = 40;
      std::bernoulli_distribution toss(density);
      std::vector<char> in(std::size_t{kSize} * kSize * kSize);
      for (char& one : in) one = toss(random) ? 1 : 0;
      const auto at = [&](int x, int y, int z) {
        const auto within = [&](int i) { return i >= 0 && i < kSize; };
        return within(x) && within(y) && within(z) &&
               in[static_cast<std::size_t>((x * kSize + y) * kSize + z)] != 0;
      };
      Frame frame;
      for (int x = 0; x < kSize / 8; ++x) {
        for (int y = 0; y < kSize / 8; ++y) {
          for (int z = 0; z < kSize / 8; ++z) {
            Block block{{x, y, z}};
            for (unsigned i = 0; i < 512; ++i) {
              if (!at(8 * x + static_cast<int>(i >> 6U), 8 * y + static_cast<int>(i >> 3U & 7U),
                      8 * z + static_cast<int>(i & 7U))) {
                continue;
              }
              block.inside[i >> 6U] |= std::uint64_t{1} << (i & 63U);
            }
            frame.blocks.push_back(block);
          }
        }
      }
      const auto layer = FrameLayer::of(std::move(frame), Lattice{}, kLargeFrame);
      ASSERT_TRUE(layer);
      const FaceMetric metric(edges);
      const double shortest = std::ranges::min(edges);
      FaceDistance distance(*layer, metric, {2, 1, 3});
      for (unsigned i = 0; i < 512; i += 7) {
        const std::array<int, 3> p = {16 + static_cast<int>(i >> 6U),
                                      8 + static_cast<int>(i >> 3U & 7U),
                                      24 + static_cast<int>(i & 7U)};
        const bool inside = at(p[0], p[1], p[2]);
        double nearest = std::numeric_limits<double>::infinity();
        constexpr int kBeyond = 24;
        for (int x = p[0] - kBeyond; x <= p[0] + kBeyond; ++x) {
          for (int y = p[1] - kBeyond; y <= p[1] + kBeyond; ++y) {
            for (int z = p[2] - kBeyond; z <= p[2] + kBeyond; ++z) {
              if (at(x, y, z) == inside) continue;
              const Eigen::Vector3d away(x - p[0], y - p[1], z - p[2]);
              const Eigen::Vector3d ofBox = (away.cwiseAbs().array() - 0.5)
                                                .max(0)
                                                .matrix()
                                                .cwiseProduct(Eigen::Vector3d(edges.data()));
              nearest = std::min(nearest, ofBox.norm() / shortest);
            }
          }
        }
        nearest = std::min<double>(nearest, FaceMetric::kMost);
        ASSERT_NEAR(distance.at(i), inside ? -nearest : nearest, 1e-6 * nearest) << i;
      }
    }
  }
}

/// A solid at the times 0, 1, 2, ..., woven from samples of a cube.
template <class T>
model::Mesh woven(const std::vector<Cube>& cubes, T in, T out, std::optional<double> iso,
                  const WeaveOptions& options = {}) {
  std::vector<std::vector<T>> values;
  for (const Cube& cube : cubes) values.push_back(cube.samples(in, out));
  model::Mesh mesh;
  if constexpr (std::is_same_v<T, char>) {
    std::vector<std::unique_ptr<bool[]>> flags;
    std::vector<ArrayFrame<bool>> frames;
    for (std::size_t i = 0; i < cubes.size(); ++i) {
      flags.push_back(std::make_unique<bool[]>(values[i].size()));
      std::ranges::transform(values[i], flags.back().get(), [](char one) { return one != 0; });
      frames.push_back({static_cast<double>(i), {flags.back().get(), values[i].size()}});
    }
    const auto size = static_cast<std::size_t>(cubes.front().size);
    auto source = arrayFrames<bool>(frames, {.size = {size, size, size}});
    EXPECT_TRUE(source && weave(**source, options, mesh));
  } else {
    std::vector<ArrayFrame<T>> frames;
    for (std::size_t i = 0; i < cubes.size(); ++i) {
      frames.push_back({static_cast<double>(i), values[i]});
    }
    const auto size = static_cast<std::size_t>(cubes.front().size);
    auto source = arrayFrames<T>(frames, {.size = {size, size, size}, .iso = iso});
    EXPECT_TRUE(source && weave(**source, options, mesh));
  }
  const auto judged = measure::checkMesh(mesh, {.vertexLinks = true});
  EXPECT_TRUE(judged && judged->valid() && judged->closed && judged->oriented);
  return mesh;
}

model::Mesh wovenMask(const std::vector<Cube>& cubes, const WeaveOptions& options = {}) {
  return woven<char>(cubes, 1, 0, {}, options);
}

double volumeAt(const model::Mesh& mesh, double time) {
  const auto slice = slice::sliceAtTime(mesh, time);
  EXPECT_TRUE(slice);
  return slice ? signedVolume(slice->mesh) : 0;
}

void expectSameCells(const model::Mesh& a, const model::Mesh& b, bool sameVertices) {
  ASSERT_EQ(a.slabCount(), b.slabCount());
  for (std::size_t i = 0; i < a.slabCount(); ++i) {
    const model::Slab& one = a.slabs()[i];
    const model::Slab& other = b.slabs()[i];
    EXPECT_EQ(one.connectivity->cells, other.connectivity->cells);
    ASSERT_EQ(one.vertices.size(), other.vertices.size());
    for (std::size_t k = 0; k < one.vertices.size(); ++k) {
      EXPECT_EQ(one.vertices[k].head<3>(), other.vertices[k].head<3>());
      if (sameVertices) {
        EXPECT_EQ(one.vertices[k][3], other.vertices[k][3]);
      }
    }
    EXPECT_TRUE(std::ranges::equal(one.lowerLayer(), other.lowerLayer()));
    EXPECT_TRUE(std::ranges::equal(one.upperLayer(), other.upperLayer()));
  }
}

TEST(WeaveMasks, ABallGrowsEvenlyWithoutAJumpInTheMiddle) {
  for (const int step : {1, 2, 3, 5}) {
    SCOPED_TRACE(step);
    std::vector<Cube> cubes;
    for (int i = 0; i < 3; ++i) cubes.push_back({56, ball({27.3, 27.7, 27.1}, 12 + step * i)});
    const model::Mesh even = wovenMask(cubes);
    const model::Mesh jumps = wovenMask(cubes, {.between = Between::Midpoint});
    expectSameCells(even, jumps, false);
    const auto errorAt = [&](const model::Mesh& mesh, double time) {
      const double radius = 12 + step * time;
      return volumeAt(mesh, time) / (4 * std::numbers::pi / 3 * std::pow(radius, 3)) - 1;
    };
    for (const double time : {0.25, 0.75, 1.25, 1.75}) {
      EXPECT_NEAR(errorAt(even, time), 0, 0.035) << time;
    }
    for (const double time : {0.499, 0.501, 1.499, 1.501}) {
      EXPECT_NEAR(errorAt(even, time), 0, 0.015) << time;
    }
    EXPECT_NEAR(volumeAt(even, 0.501) / volumeAt(even, 0.499), 1, 0.005);
    if (step > 1) {
      EXPECT_GT(std::abs(errorAt(jumps, 0.501)), 0.05);
    }
  }
}

TEST(WeaveMasks, ASolidThatMovesByVoxelsIsInTheMiddleBetweenThem) {
  // Faces along the axes, one voxel a frame: the published crossings.
  const auto box = [](double from) {
    return Cube{24, [=](const Eigen::Vector3d& p) {
                  return (p.array() >= Eigen::Array3d(from, 5, 6)).all() &&
                         (p.array() < Eigen::Array3d(from + 8, 12, 14)).all();
                }};
  };
  const std::vector<Cube> cubes = {box(4), box(5), box(6)};
  expectSameCells(wovenMask(cubes), wovenMask(cubes, {.between = Between::Midpoint}), true);
  // Three voxels a frame: where it is at any time, and not only up to the middle.
  const model::Mesh fast = wovenMask({box(4), box(7), box(10)});
  for (const double time : {0.2, 0.4, 0.6, 0.8}) {
    const auto slice = slice::sliceAtTime(fast, time);
    ASSERT_TRUE(slice);
    EXPECT_NEAR(boundsOf(slice->mesh).min.x(), 3.5 + 3 * time, 0.6) << time;
    EXPECT_NEAR(boundsOf(slice->mesh).max.x(), 11.5 + 3 * time, 0.6) << time;
  }
}

TEST(WeaveMasks, SamplesOfTwoValuesAreMasks) {
  std::vector<Cube> cubes;
  for (int i = 0; i < 2; ++i) cubes.push_back({40, ball({19.3, 19.7, 19.1}, 9 + 3 * i)});
  const model::Mesh mask = wovenMask(cubes);
  expectSameCells(mask, woven<float>(cubes, 1, 0, 0.5), true);
  expectSameCells(mask, woven<double>(cubes, -1, 1, {}), true);
  const double jump = volumeAt(wovenMask(cubes, {.between = Between::Midpoint}), 0.501);
  EXPECT_NEAR(volumeAt(woven<float>(cubes, 1, 0, 0.5, {.between = Between::Midpoint}), 0.501), jump,
              1e-3 * jump);
}

TEST(WeaveMasks, DistancesCountTheEdgesOfVoxels) {
  // A slab of voxels that are long along z and grows along x and z by lengths that are alike.
  const auto box = [](int x, int z) {
    return Cube{32, [=](const Eigen::Vector3d& p) {
                  return p.x() >= 4 && p.x() < 4 + x && p.y() >= 4 && p.y() < 28 && p.z() >= 4 &&
                         p.z() < 4 + z;
                }};
  };
  model::Affine3x4 toSpace = model::Affine3x4::Zero();
  toSpace.diagonal() << 1, 1, 4;
  const model::Mesh mesh = wovenMask({box(12, 12), box(16, 13)}, {.toSpace = toSpace});
  const auto half = slice::sliceAtTime(mesh, 0.49);
  ASSERT_TRUE(half);
  EXPECT_NEAR(boundsOf(half->mesh).max.x(), 15.5 + 2, 0.6);
}

TEST(WeaveMasks, WhatAppearsFarFromEverythingGrowsFromItsMiddle) {
  const Cube nothing{40, [](const Eigen::Vector3d&) { return false; }};
  const Cube solid{40, ball({19, 19, 19}, 8)};
  const model::Mesh mesh = wovenMask({nothing, solid, nothing});
  const double whole = volumeAt(mesh, 1);
  // Everything counts as 24.5 voxels away, and the middle of the ball is 8 from its surface.
  EXPECT_EQ(volumeAt(mesh, 0.7), 0);
  EXPECT_NEAR(volumeAt(mesh, 0.9) / whole, std::pow(1 - 24.5 * (1 / 0.9 - 1) / 8, 3), 0.1);
  EXPECT_NEAR(volumeAt(mesh, 0.99) / whole, 1, 0.2);
  EXPECT_NEAR(volumeAt(mesh, 1.1), volumeAt(mesh, 0.9), 0.02 * whole);
  EXPECT_EQ(volumeAt(mesh, 1.3), 0);
}

}  // namespace
}  // namespace t4d::voxel4d
