#include "voxel4d/frame_spacing.h"

#include <array>
#include <random>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "t4d/weave.h"

namespace t4d::voxel4d {
namespace {

using model::Point3;

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double number(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  Eigen::Vector3d vector(double size) {
    return {number(-size, size), number(-size, size), number(-size, size)};
  }

 private:
  std::mt19937 engine_;
};

/// A sequence of screws: rotations of any size about axes near and far, with translations in any
/// direction, fast and slow.
model::Motion randomMotion(Random& random) {
  std::vector<model::ScrewRun> runs;
  const int count = static_cast<int>(random.number(1, 4));
  for (int i = 0; i < count; ++i) {
    runs.push_back(
        {random.number(0.5, 2),
         {random.vector(30), random.vector(1), random.number(-500, 500), random.vector(20)},
         1});
  }
  return *model::chainScrews(random.number(-5, 5), runs);
}

/// The maximum distance that a vertex moves within a frame's time, from samples.
double sampledMove(const model::TriangleMesh& mesh, const model::Motion& motion,
                   const std::vector<double>& times) {
  constexpr int kSamples = 4;
  double farthest = 0;
  for (std::size_t i = 0; i + 1 < times.size(); ++i) {
    std::vector<model::Pose> poses;
    for (int k = 0; k <= kSamples; ++k) {
      poses.push_back(motion.at(times[i] + (times[i + 1] - times[i]) * k / kSamples));
    }
    for (const Point3& vertex : mesh.vertices) {
      std::array<Point3, kSamples + 1> path;
      for (int k = 0; k <= kSamples; ++k) {
        path[k] = poses[k](vertex);
        for (int j = 0; j < k; ++j) farthest = std::max(farthest, (path[k] - path[j]).norm());
      }
    }
  }
  return farthest;
}

TEST(FrameSpacing, NoPointMovesFurtherThanAVoxelAndATenthOfTheFramesDoesNotSuffice) {
  Random random(1);
  for (int i = 0; i < 20; ++i) {
    model::TriangleMesh mesh = fixtures::cube(random.number(5, 20));
    for (Point3& vertex : mesh.vertices) vertex += random.vector(10);
    const model::Motion motion = randomMotion(random);
    const model::TimeSpan span{motion.timeBegin(), motion.timeEnd()};
    const double voxel = random.number(1, 2);
    const auto frames = framesWithin(voxel, maxSpeed(mesh, motion), span);
    ASSERT_TRUE(frames) << frames.error().text();
    EXPECT_LE(sampledMove(mesh, motion, model::evenTimes(span, *frames)), voxel * (1 + 1e-9)) << i;
    const std::uint64_t tenth = std::max<std::uint64_t>(2, *frames / 10);
    ASSERT_LT(tenth, *frames);
    EXPECT_GT(sampledMove(mesh, motion, model::evenTimes(span, tenth)), voxel) << i;
  }
}

TEST(FrameSpacing, TheLargestSpeedIsReached) {
  Random random(2);
  for (int i = 0; i < 20; ++i) {
    model::TriangleMesh mesh = fixtures::cube(10);
    for (Point3& vertex : mesh.vertices) vertex += random.vector(10);
    const model::Motion motion = randomMotion(random);
    const double bound = maxSpeed(mesh, motion);
    double sampled = 0;
    for (const model::Segment& segment : motion.segments) {
      constexpr int kSamples = 500;
      const double duration = segment.timeEnd - segment.timeBegin;
      for (int k = 0; k < kSamples; ++k) {
        const model::Pose from = segment.at(static_cast<double>(k) / kSamples);
        const model::Pose to = segment.at((k + 1.0) / kSamples);
        for (const Point3& vertex : mesh.vertices) {
          sampled = std::max(sampled, (to(vertex) - from(vertex)).norm() / (duration / kSamples));
        }
      }
    }
    EXPECT_LE(sampled, bound * (1 + 1e-9)) << i;
    EXPECT_GE(sampled, bound * (1 - 1e-3)) << i;
  }
}

TEST(FrameSpacing, AVoxelAFrameIsEnoughForATranslation) {
  model::ScrewRun run{1, {}, 64};
  run.screw.translation = {0, 0, 1};
  const model::Motion motion = *model::chainScrews(0, std::span(&run, 1));
  const double speed = maxSpeed(fixtures::paperCube(20), motion);
  EXPECT_EQ(speed, 1);
  EXPECT_EQ(framesWithin(1, speed, {0, 64}), 65U);
  EXPECT_EQ(framesWithin(0.1, speed, {0, 64}), 641U);
  EXPECT_EQ(framesWithin(0.3, speed, {0, 64}), 215U);
}

TEST(FrameSpacing, AWholeNumberOfDistancesIsNotRoundedUp) {
  // In doubles 3 * 0.1 / 0.1 is more than 3.
  for (std::uint64_t count = 1; count <= 1000; ++count) {
    EXPECT_EQ(framesWithin(0.1, 0.1, {0, static_cast<double>(count)}), count + 1);
  }
}

TEST(FrameSpacing, ARestTakesTwoFramesAndTooManyAreRefused) {
  const model::ScrewRun rest{10, {}, 1};
  const double speed = maxSpeed(fixtures::cube(2), *model::chainScrews(0, std::span(&rest, 1)));
  EXPECT_EQ(speed, 0);
  EXPECT_EQ(framesWithin(1, speed, {0, 10}), 2U);
  EXPECT_EQ(framesWithin(1, 1, {0, kMaxFrames - 1.0}), kMaxFrames);
  const auto tooMany = framesWithin(1, 1, {0, kMaxFrames});
  ASSERT_FALSE(tooMany);
  EXPECT_NE(tooMany.error().message.find("at most 1000000"), std::string::npos);
  EXPECT_FALSE(framesWithin(1e-300, 1e300, {0, 1}));
  EXPECT_EQ(maxSpeed({}, *model::chainScrews(0, std::span(&rest, 1))), 0);
}

TEST(FrameSpacing, TheLargestGapCounts) {
  EXPECT_EQ(largestGap(std::vector<double>{0, 1, 3, 4}), 2);
  EXPECT_EQ(largestGap(std::vector<double>{5}), 0);
}

}  // namespace
}  // namespace t4d::voxel4d
