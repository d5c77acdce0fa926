#include "mesh4d/steps.h"

#include <array>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "mesh4d/test_motion.h"

namespace t4d::mesh4d {
namespace {

TEST(Steps, ThePapersScrewHas65) {
  // Section 5.2: 360 degrees with R_Vmin = 0.9976 are 65 steps of 5.538 degrees.
  const auto steps = stepsOf(turnAbout(Eigen::Vector3d::UnitX(), 360, 100), MinVolumeRatio{0.9976});
  EXPECT_EQ(steps->front(), 65U);
  EXPECT_NEAR(360.0 / 65, 5.538, 5e-4);
}

TEST(Steps, EveryStepKeepsTheVolumeAndOneFewerWouldNot) {
  for (const double ratio : {0.0, 0.3, 0.5, 0.75, 0.9, 0.998, 0.99999}) {
    for (const double degrees : {-720.0, 1.0, 90.0, 180.0, 359.0, 360.0}) {
      const auto steps =
          stepsOf(turnAbout(Eigen::Vector3d::UnitX(), degrees), MinVolumeRatio{ratio});
      const auto volume = [&](double n) {
        return (1 + std::cos(std::abs(degrees) / n * M_PI / 180)) / 2;
      };
      const auto n = static_cast<double>(steps->front());
      EXPECT_GE(volume(n), ratio - 1e-9);
      EXPECT_LE(std::abs(degrees) / n, 180 + 1e-9);
      if (n > 1 && std::abs(degrees) / (n - 1) <= 180) {
        EXPECT_LT(volume(n - 1), ratio);
      }
    }
  }
}

TEST(Steps, ChordsAreOfTheFarthestVertexAndTheLongestEdgeAcrossTheAxis) {
  // A box that turns about its edge along x: its farthest edge is 5 away, and so long are the
  // diagonals of its ends.
  model::TriangleMesh box = fixtures::cube(1);
  for (model::Point3& v : box.vertices) {
    v = {10 * v.x(), 3 * (v.y() + 0.5), 4 * (v.z() + 0.5)};
  }
  const auto chords = chordsOf(turnAbout(Eigen::Vector3d::UnitX(), 90), box, PrismSplit::Fourteen);
  ASSERT_EQ(chords.size(), 1U);
  EXPECT_NEAR(chords[0].radius, 5, 1e-12);
  EXPECT_NEAR(chords[0].edge, 5, 1e-12);
}

TEST(Steps, WholeMultiplesAreNotRoundedUp) {
  const model::Motion turn = turnAbout(Eigen::Vector3d::UnitX(), 360);
  for (std::uint64_t steps = 2; steps <= 60; ++steps) {
    const double ratio = (1 + std::cos(2 * M_PI / static_cast<double>(steps))) / 2;
    EXPECT_EQ(stepsOf(turn, MinVolumeRatio{ratio})->front(), steps);
  }
}

TEST(Steps, KeepADeviationAndOneFewerWouldNot) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int seed = 0; seed < 2000; ++seed) {
    const model::Chords chords{std::pow(10, 6 * unit(random) - 3),
                               std::pow(10, 6 * unit(random) - 3),
                               seed % 2 == 0 ? model::kEdgeFactorOf14 : model::kEdgeFactorOf3};
    const double degrees = 1000 * unit(random);
    const double allowed = std::pow(10, 8 * unit(random) - 5) * chords.radius;
    const model::Motion motion = turnAbout(Eigen::Vector3d::UnitX(), degrees);
    const auto steps = stepsOf(motion, MaxDeviation{allowed}, {&chords, 1});
    if (!steps) continue;
    const auto bound = [&](double n) { return chords.forAngle(degrees / n * M_PI / 180); };
    const auto n = static_cast<double>(steps->front());
    SCOPED_TRACE(testing::Message() << chords.radius << " " << chords.edge << " " << allowed);
    if (degrees / n < 180 * (1 - 1e-12)) {
      EXPECT_LE(bound(n), allowed);
      EXPECT_NEAR(largestDeviation(motion, *steps, {&chords, 1}), bound(n), 1e-12 * bound(n));
    }
    EXPECT_LE(degrees / n, 180 + 1e-9);
    if (n > 1 && degrees / (n - 1) <= 180) {
      EXPECT_GT(bound(n - 1), allowed * (1 - 1e-9));
    }
  }
}

TEST(Steps, ADeviationThatIsTooSmallIsRefusedWithOneThatIsPossible) {
  for (const double degrees : {3600.0, 0.25}) {
    // The solid turns there and back.
    std::vector<model::ScrewRun> runs(2, {.duration = 1, .screw = {.angleDegrees = degrees}});
    runs[1].screw.angleDegrees *= -1;
    const model::Motion motion = *model::chainScrews(0, runs);
    for (const double edge : {0.0, 0.3, 40.0}) {
      const std::array chords = {model::Chords{5, edge}, model::Chords{5, edge}};
      const auto refused = stepsOf(motion, MaxDeviation{1e-300}, chords);
      ASSERT_FALSE(refused);
      const std::string& message = refused.error().message;
      const auto at = message.find("a deviation of ");
      ASSERT_NE(at, std::string::npos) << message;
      const double possible = std::stod(message.substr(at + 15));
      EXPECT_TRUE(stepsOf(motion, MaxDeviation{possible}, chords)) << message;
      EXPECT_FALSE(stepsOf(motion, MaxDeviation{possible / 2}, chords)) << message;
    }
  }
}

TEST(Steps, RulesOutOfRangeAreRefused) {
  const model::Motion motion = turnAbout(Eigen::Vector3d::UnitX(), 360);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const StepRule& rule :
       {StepRule(MinVolumeRatio{1}), StepRule(MinVolumeRatio{-0.1}), StepRule(MinVolumeRatio{nan}),
        StepRule(StepsPerSegment{0}), StepRule(MaxDeviation{0}), StepRule(MaxDeviation{nan}),
        StepRule(MinVolumeRatio{1 - 1e-16}), StepRule(StepsPerSegment{~std::uint64_t{0}}),
        StepRule(MaxDeviation{1e-300})}) {
    const auto steps = stepsOf(motion, rule, std::array{model::Chords{1, 1}});
    ASSERT_FALSE(steps);
    EXPECT_EQ(steps.error().code, ErrorCode::InvalidInput);
  }
}

}  // namespace
}  // namespace t4d::mesh4d
