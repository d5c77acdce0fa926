#include "t4d/motion.h"

#include <array>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace t4d::model {
namespace {

constexpr double kTolerance = 1e-12;

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double number(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  Eigen::Vector3d vector(double size) {
    return {number(-size, size), number(-size, size), number(-size, size)};
  }
  Eigen::Quaterniond quaternion() {
    return Eigen::Quaterniond(number(-1, 1), number(-1, 1), number(-1, 1), number(-1, 1))
        .normalized();
  }

 private:
  std::mt19937 engine_;
};

double difference(const Pose& a, const Pose& b) {
  return std::max((a.rotation - b.rotation).cwiseAbs().maxCoeff(),
                  (a.translation - b.translation).cwiseAbs().maxCoeff());
}

TEST(Screw, QuarterAndWholeTurnsAreExact) {
  const Screw screw{{1, 2, 3}, Eigen::Vector3d::UnitZ(), 360, {0, 0, 20}};
  EXPECT_EQ(screw.at(1).rotation, Eigen::Matrix3d::Identity());
  EXPECT_EQ(screw.at(1)(Point3(4, 5, 6)), Point3(4, 5, 26));
  EXPECT_EQ(screw.at(0.25)(Point3(4, 5, 6)), Point3(-2, 5, 11));
  EXPECT_EQ(screw.at(0.5)(Point3(4, 5, 6)), Point3(-2, -1, 16));
}

TEST(Screw, AgreesWithEigensRotation) {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d axis = random.vector(1).normalized();
    const double degrees = random.number(-1000, 1000);
    const Screw screw{random.vector(10), axis, degrees, random.vector(5)};
    const double fraction = random.number(0, 1);
    const Point3 p = random.vector(10);
    const Eigen::AngleAxisd turn(degrees * fraction * std::numbers::pi / 180, axis);
    const Point3 expected =
        screw.axisPoint + turn * (p - screw.axisPoint) + fraction * screw.translation;
    EXPECT_LT((screw.at(fraction)(p) - expected).norm(), 1e-11);
  }
}

TEST(Screw, TinyTurnsAboutAFarAxisKeepAllDigits) {
  // The origin moves towards the axis by r (1 - cos a) = 2 r sin^2 (a / 2).
  constexpr double kRadius = 1e9;
  for (const double degrees : {60.0, 1.0, 1e-3, -1e-5, 1e-7, -1e-9}) {
    const Screw screw{{kRadius, 0, 0}, Eigen::Vector3d::UnitZ(), degrees, Point3::Zero()};
    const Point3 moved = screw.at(1)(Point3::Zero());
    const long double radians = degrees * std::numbers::pi_v<long double> / 180;
    const long double sine = std::sin(radians / 2);
    EXPECT_DOUBLE_EQ(moved.x(), static_cast<double>(2 * kRadius * sine * sine)) << degrees;
    EXPECT_DOUBLE_EQ(moved.y(), static_cast<double>(-kRadius * std::sin(radians))) << degrees;
  }
}

TEST(Motion, SegmentsBeginAndEndAtDecimals) {
  const ScrewRun tenths{0.1, {}, 7};
  const ScrewRun once{0.7, {}, 2};
  const Motion motion = *chainScrews(0, std::array{tenths, once});
  const std::vector<double> ends = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 1.4, 2.1};
  ASSERT_EQ(motion.segments.size(), ends.size());
  for (std::size_t i = 0; i < ends.size(); ++i) {
    EXPECT_EQ(motion.segments[i].timeBegin, i == 0 ? 0 : ends[i - 1]);
    EXPECT_EQ(motion.segments[i].timeEnd, ends[i]);
  }
}

TEST(Motion, RepeatedTranslationIsExact) {
  Screw up;
  up.translation = {0, 0, 1};
  const ScrewRun run{1, up, 64};
  const Motion motion = *chainScrews(0, std::span(&run, 1));
  ASSERT_EQ(motion.segments.size(), 64U);
  EXPECT_EQ(motion.timeEnd(), 64);
  EXPECT_EQ(motion.at(31.5)(Point3::Zero()), Point3(0, 0, 31.5));
}

TEST(Motion, SegmentsJoinWithoutAGap) {
  Random random(2);
  std::vector<ScrewRun> runs;
  for (int i = 0; i < 10; ++i) {
    runs.push_back(
        {random.number(0.1, 2),
         {random.vector(3), random.vector(1), random.number(-400, 400), random.vector(3)},
         static_cast<std::uint64_t>(1 + i % 3)});
  }
  const Motion motion = *chainScrews(-5, runs);
  for (std::size_t i = 0; i + 1 < motion.segments.size(); ++i) {
    EXPECT_EQ(motion.segments[i].timeEnd, motion.segments[i + 1].timeBegin);
    EXPECT_EQ(difference(motion.segments[i].end, motion.segments[i + 1].start), 0);
  }
}

TEST(Motion, ScrewThroughTwoPosesReachesBothAndIsAScrew) {
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const KeyPose poses[] = {{0, random.vector(5), random.quaternion()},
                             {2, random.vector(5), random.quaternion()}};
    const Motion motion = *joinPoses(poses);
    const Segment& segment = motion.segments.front();
    const Screw& screw = segment.screw;
    EXPECT_LT(difference(screw.at(1) * segment.start, segment.end), kTolerance * 100);
    EXPECT_LE(screw.angleDegrees, 180 + 1e-9);
    // Chasles: the translation is along the axis.
    EXPECT_LT(screw.axisDirection.cross(screw.translation).norm(), 1e-10);
  }
}

TEST(Motion, NearlyEqualPosesStayNearTheStraightLine) {
  const Eigen::Quaterniond tiny(Eigen::AngleAxisd(1e-9, Eigen::Vector3d(1, 2, 2) / 3));
  const KeyPose poses[] = {{0, {1, 2, 3}, Eigen::Quaterniond::Identity()}, {1, {4, 7, 1}, tiny}};
  const Motion motion = *joinPoses(poses);
  EXPECT_LT((motion.at(0.5)(Point3::Zero()) - Point3(2.5, 4.5, 2)).norm(), 1e-8);
}

TEST(Motion, TurnsOfHalfATurnUpToRoundingAreListed) {
  Random random(5);
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d axis = random.vector(1).normalized();
    const Eigen::Quaterniond from = random.quaternion();
    const double off = std::pow(10, random.number(-12, 1.5));
    const Eigen::Quaterniond to =
        Eigen::Quaterniond(Eigen::AngleAxisd((180 - off) * std::numbers::pi / 180, axis)) * from;
    KeyPose first{1, random.vector(3), from};
    KeyPose second{2, random.vector(3), to};
    second.quaternion.normalize();
    const auto motion = joinPoses(std::array{first, second});
    ASSERT_TRUE(motion);
    const bool listed = !motion->halfTurns.empty();
    EXPECT_EQ(listed, off < 180 - kHalfTurnDegrees) << off;
    if (!listed) continue;
    EXPECT_EQ(motion->halfTurns[0].between, "poses 0 and 1 (counted from 0)");
    EXPECT_NEAR(std::abs(motion->halfTurns[0].axis.dot(axis)), 1, 1e-9);
    EXPECT_EQ(motion->halfTurns[0].axis, motion->segments[0].screw.axisDirection);
  }
  // Segments say which way they turn.
  ScrewRun half;
  half.duration = 1;
  half.screw.angleDegrees = 180;
  EXPECT_TRUE(chainScrews(0, {&half, 1})->halfTurns.empty());
  EXPECT_EQ(noticeOfHalfTurns({}), "");
}

TEST(Motion, OppositeQuaternionsAreTheSameRotation) {
  const Eigen::Quaterniond q(0.5, 0.5, 0.5, 0.5);
  const KeyPose poses[] = {{0, {0, 0, 0}, q},
                           {1, {0, 0, 1}, Eigen::Quaterniond(-0.5, -0.5, -0.5, -0.5)}};
  const Motion motion = *joinPoses(poses);
  EXPECT_EQ(motion.segments.front().screw.angleDegrees, 0);
}

TEST(Motion, WhatIsNoMotionIsRefused) {
  const auto refuse = [](const ScrewRun& run, const char* expected, double start = 0) {
    const auto motion = chainScrews(start, std::span(&run, 1));
    ASSERT_FALSE(motion) << expected;
    EXPECT_EQ(motion.error().code, ErrorCode::InvalidInput);
    EXPECT_NE(motion.error().text().find(expected), std::string::npos) << motion.error().text();
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Screw turn;
  turn.angleDegrees = 10;
  Screw noAxis = turn;
  noAxis.axisDirection.setZero();
  Screw noNumber = turn;
  noNumber.translation[1] = nan;
  refuse({0, turn, 1}, "backward through time");
  refuse({-1, turn, 1}, "backward through time");
  refuse({nan, turn, 1}, "must be positive");
  refuse({1, noAxis, 1}, "length 0");
  refuse({1, noNumber, 1}, "not finite");
  Screw nowhere = turn;
  nowhere.axisPoint[2] = nan;
  refuse({1, nowhere, 1}, "not finite");
  Screw noDirection = turn;
  noDirection.axisDirection[0] = nan;
  refuse({1, noDirection, 1}, "not finite");
  Screw noAngle = turn;
  noAngle.angleDegrees = nan;
  refuse({1, noAngle, 1}, "not finite");
  refuse({1, turn, 0}, "repeats 0 times");
  refuse({1, turn, ~std::uint64_t{0}}, "repeats");
  refuse({1e-20, turn, 1}, "too short to represent", 1e6);
  refuse({1, turn, 1}, "start time", nan);
  EXPECT_FALSE(chainScrews(0, {}));
}

TEST(Motion, PosesThatGoBackwardOrAreNoRotationsAreRefused) {
  const KeyPose still[] = {{0, {}, Eigen::Quaterniond::Identity()}};
  EXPECT_FALSE(joinPoses(still));
  const KeyPose back[] = {{1, Point3::Zero(), Eigen::Quaterniond::Identity()},
                          {1, Point3::Zero(), Eigen::Quaterniond::Identity()}};
  EXPECT_NE(joinPoses(back).error().message.find("backward"), std::string::npos);
  const KeyPose long2[] = {{0, Point3::Zero(), Eigen::Quaterniond(2, 0, 0, 0)},
                           {1, Point3::Zero(), Eigen::Quaterniond::Identity()}};
  EXPECT_NE(joinPoses(long2).error().message.find("length 2"), std::string::npos);
}

}  // namespace
}  // namespace t4d::model
