#include "t4d/mesh4d/steps.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "t4d/mesh4d/test_motion.h"

namespace t4d::mesh4d {
namespace {

TEST(Steps, ThePapersScrewHas65) {
  // Section 5.2: 360 degrees with R_Vmin = 0.9976 are 65 steps of 5.538 degrees.
  const auto steps =
      stepsOf(turnAbout(Eigen::Vector3d::UnitX(), 360, 100), MinVolumeRatio{0.9976}, {});
  EXPECT_EQ(steps->front(), 65U);
  EXPECT_NEAR(360.0 / 65, 5.538, 5e-4);
}

TEST(Steps, EveryStepKeepsTheVolumeAndOneFewerWouldNot) {
  for (const double ratio : {0.0, 0.3, 0.5, 0.75, 0.9, 0.998, 0.99999}) {
    for (const double degrees : {-720.0, 1.0, 90.0, 180.0, 359.0, 360.0}) {
      const auto steps =
          stepsOf(turnAbout(Eigen::Vector3d::UnitX(), degrees), MinVolumeRatio{ratio}, {});
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

TEST(Steps, WholeMultiplesAreNotRoundedUp) {
  // acos(0) is a quarter turn.
  EXPECT_EQ(stepsOf(turnAbout(Eigen::Vector3d::UnitX(), 360), MinVolumeRatio{0.5}, {})->front(),
            4U);
}

TEST(Steps, RulesOutOfRangeAreRefused) {
  const model::Motion motion = turnAbout(Eigen::Vector3d::UnitX(), 360);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const StepRule& rule :
       {StepRule(MinVolumeRatio{1}), StepRule(MinVolumeRatio{-0.1}), StepRule(MinVolumeRatio{nan}),
        StepRule(StepsPerSegment{0}), StepRule(MaxDeviation{0}), StepRule(MaxDeviation{nan}),
        StepRule(MinVolumeRatio{1 - 1e-16}), StepRule(StepsPerSegment{~std::uint64_t{0}}),
        StepRule(MaxDeviation{1e-300})}) {
    const auto steps = stepsOf(motion, rule, {{0, 1, 0}});
    ASSERT_FALSE(steps);
    EXPECT_EQ(steps.error().code, ErrorCode::InvalidInput);
  }
}

}  // namespace
}  // namespace t4d::mesh4d
