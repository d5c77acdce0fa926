#include "t4d/collide.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "measure/chord_bound.h"
#include "measure/collision_verdict.h"
#include "measure/overlap.h"
#include "model/parallel.h"
#include "t4d/motion.h"
#include "t4d/sweep.h"

namespace t4d::measure {
namespace {

using Eigen::Vector3d;
using model::Mesh;
using model::Screw;
using model::TriangleMesh;

/// A mesh, moved by equal screws one after another.
Mesh moved(const TriangleMesh& mesh, const Screw& screw, double duration = 1,
           std::uint64_t steps = 1, double start = 0) {
  const model::ScrewRun run{duration, screw, 1};
  const auto motion = model::chainScrews(start, {&run, 1});
  Mesh made;
  const auto report = mesh4d::sweep(mesh, *motion, {.steps = mesh4d::StepsPerSegment{steps}}, made);
  EXPECT_TRUE(report) << report.error().text();
  return made;
}

Screw along(const Vector3d& by) {
  Screw screw;
  screw.translation = by;
  return screw;
}

Screw about(const Vector3d& axis, double degrees) {
  Screw screw;
  screw.axisDirection = axis.normalized();
  screw.angleDegrees = degrees;
  return screw;
}

Collision collided(const Mesh& a, const Mesh& b, const CollideOptions& options = {}) {
  auto found = collide(a, b, options);
  EXPECT_TRUE(found) << found.error().text();
  return found ? *found : Collision{};
}

TEST(Collide, CubesMeetFaceToFaceAtTheRightTime) {
  // Faces at x = 1 and 4 approach each other by 7 in one unit of time.
  const Mesh a = moved(fixtures::cube(2), along({3, 0, 0}));
  const Mesh b = moved(fixtures::translated(fixtures::cube(2), {5, 0, 0}), along({-4, 0, 0}));
  const Collision found = collided(a, b);
  ASSERT_EQ(found.intervals.size(), 1U);
  const ContactInterval& interval = found.intervals[0];
  EXPECT_NEAR(interval.begin, 3.0 / 7, 1e-12);
  EXPECT_NEAR(interval.end, 1, 0);
  EXPECT_TRUE(interval.overlaps);
  EXPECT_NEAR(interval.first.point.x(), 1 + 9.0 / 7, 1e-12);
  EXPECT_NEAR(interval.deepestTime, 5.0 / 7, 1e-2);
  EXPECT_NEAR(interval.overlapVolume, 8, 0.05);
}

TEST(CollideAll, FindsOfEachPairWhatItFindsOfThatPairAlone) {
  // Other steps, other times, contacts, parts inside others, and sizes in units of their own.
  TriangleMesh dust = fixtures::cube(1);
  for (auto& vertex : dust.vertices) vertex *= 1e-60;
  const std::vector<Mesh> bodies = {
      moved(fixtures::translated(fixtures::cube(2), {5, 0, 0}), about({0, 0, 1}, 90), 1, 7),
      moved(fixtures::icosphere(1, 1), along({9, 0.5, 0}), 2, 3, 0.5),
      moved(fixtures::cube(30), along({0, 0, 0}), 1, 1, 0.25),
      moved(fixtures::translated(fixtures::cube(2), {0, 5, 1}), along({0, 0, 0}), 5, 1, -1),
      moved(fixtures::translated(fixtures::cube(1), {50, 0, 0}), along({-3, 0, 0}), 1, 4),
      moved(dust, along({0, 1e-60, 0})),
      moved(fixtures::cube(1), along({1, 0, 0}), 1, 2, 40)};
  std::vector<SourcePair> pairs;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    for (std::size_t j = i + 1; j < bodies.size(); ++j) pairs.push_back({&bodies[i], &bodies[j]});
  }
  for (const bool overTime : {false, true}) {
    const CollideOptions options{.clearanceOverTime = overTime};
    const auto all = collideAll(pairs, options);
    ASSERT_TRUE(all);
    ASSERT_EQ(all->size(), pairs.size());
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      SCOPED_TRACE(i);
      const auto alone = collide(*pairs[i].a, *pairs[i].b, options);
      ASSERT_TRUE(alone);
      const Collision& together = (*all)[i];
      EXPECT_EQ(together.common.has_value(), alone->common.has_value());
      ASSERT_EQ(together.intervals.size(), alone->intervals.size());
      for (std::size_t k = 0; k < alone->intervals.size(); ++k) {
        EXPECT_EQ(together.intervals[k].begin, alone->intervals[k].begin);
        EXPECT_EQ(together.intervals[k].end, alone->intervals[k].end);
        EXPECT_EQ(together.intervals[k].overlapVolume, alone->intervals[k].overlapVolume);
      }
      ASSERT_EQ(together.clearance.has_value(), alone->clearance.has_value());
      if (alone->clearance) {
        EXPECT_EQ(together.clearance->distance, alone->clearance->distance);
        EXPECT_EQ(together.clearance->lowerBound, alone->clearance->lowerBound);
        EXPECT_EQ(together.clearance->time, alone->clearance->time);
      }
      EXPECT_EQ(together.clearanceOverTime.size(), alone->clearanceOverTime.size());
    }
  }
}

TEST(Collide, AVertexMeetsAFaceAtTheRightTime) {
  // An octahedron with corners on the axes, from a face at x = 4.
  for (const int gap : {1, 2, 3, 7}) {
    for (const double speed : {9.0, 11.0, 13.0}) {
      const Mesh a = moved(fixtures::bipyramid(4), along({speed, 0.25, -0.125}));
      const Mesh b =
          moved(fixtures::translated(fixtures::cube(2), {2.0 + gap, 0, 0}), along({0, 0, 0}));
      const Collision found = collided(a, b);
      ASSERT_EQ(found.intervals.size(), 1U);
      const double time = gap / speed;
      EXPECT_NEAR(found.intervals[0].begin, time, 1e-12);
      EXPECT_NEAR(
          (found.intervals[0].first.point - model::Point3(1.0 + gap, time / 4, -time / 8)).norm(),
          0, 1e-12);
      EXPECT_TRUE(found.intervals[0].overlaps);
    }
  }
}

/// A bar along z whose section is the square |x| + |y| <= 1.
TriangleMesh diamondBar() {
  TriangleMesh bar = fixtures::cube(2);
  for (auto& v : bar.vertices) v = {(v.x() + v.y()) / 2, (v.y() - v.x()) / 2, v.z()};
  return bar;
}

TEST(Collide, EdgesMeetAtTheRightTime) {
  TriangleMesh across = diamondBar();
  for (auto& v : across.vertices) v = {v.x(), -v.z(), v.y()};
  for (const int gap : {1, 2, 3, 7}) {
    for (const double speed : {5.0, 9.0, 13.0}) {
      const Mesh a = moved(diamondBar(), along({speed, 0, 0.5}));
      const Mesh b =
          moved(fixtures::translated(across, {2.0 + gap, 0, 0}), along({-speed, 0.25, 0}));
      const Collision found = collided(a, b);
      ASSERT_EQ(found.intervals.size(), 1U);
      EXPECT_NEAR(found.intervals[0].begin, gap / (2 * speed), 1e-12);
      EXPECT_NEAR(found.intervals[0].first.point.x(), 1 + gap / 2.0, 1e-12);
      EXPECT_TRUE(found.intervals[0].overlaps);
    }
  }
}

TEST(Collide, FineBallsMeetWhenBallsDo) {
  const TriangleMesh ball = fixtures::icosphere(1, 3);
  double inner = 1;
  for (const auto& [i, j, k] : ball.triangles) {
    const auto& p = ball.vertices;
    const Vector3d normal = (p[j] - p[i]).cross(p[k] - p[i]).normalized();
    inner = std::min(inner, normal.dot(p[i]));
  }
  const Mesh a = moved(fixtures::translated(ball, {-4, 1, 0}), along({8, 0, 0}), 1, 8);
  const Mesh b = moved(ball, along({0, 0, 0}));
  const Collision found = collided(a, b);
  ASSERT_EQ(found.intervals.size(), 1U);
  // The centres pass each other 1 apart; a distance of 2 is that of balls, 2 * inner that of the
  // balls inside the meshes.
  const double ball2 = std::sqrt(3) / 8;
  const double inner2 = std::sqrt(4 * inner * inner - 1) / 8;
  EXPECT_GE(found.intervals[0].begin, 0.5 - ball2);
  EXPECT_LE(found.intervals[0].begin, 0.5 - inner2);
  EXPECT_LE(found.intervals[0].end, 0.5 + ball2);
  EXPECT_GE(found.intervals[0].end, 0.5 + inner2);
  EXPECT_NEAR(found.intervals[0].deepestTime, 0.5, 0.05);
  // Two caps of height 1/2.
  const double lens = 2 * std::numbers::pi / 3 * 0.25 * 2.5;
  EXPECT_NEAR(found.intervals[0].overlapVolume, lens, 0.05 * lens);
}

TEST(Collide, TheDeepestTimeIsFoundBetweenSamples) {
  // They overlap by 4 (2 - |x|), as x goes from -2 to `end` in a unit of time. Twelve golden
  // sections of the two steps beside a sample are left.
  const double left = 2.0 / kOverlapSamples * std::pow(std::numbers::phi, -12);
  for (const double end : {1.3, 0.7}) {
    const Mesh a =
        moved(fixtures::translated(fixtures::cube(2), {-2, 0, 0}), along({2 + end, 0, 0}));
    const Mesh b = moved(fixtures::cube(2), along({0, 0, 0}));
    const Collision found = collided(a, b, {.clearance = false});
    ASSERT_EQ(found.intervals.size(), 1U);
    EXPECT_NEAR(found.intervals[0].deepestTime, 2 / (2 + end), left);
  }
}

TEST(Collide, NeighboursOnlyTouch) {
  const Mesh a = moved(fixtures::cube(2), along({0, 1, 0}));
  const Mesh b = moved(fixtures::translated(fixtures::cube(2), {2, 0, 0}), along({0, 0, 1}));
  const Collision found = collided(a, b);
  ASSERT_EQ(found.intervals.size(), 1U);
  EXPECT_EQ(found.intervals[0].begin, 0);
  EXPECT_EQ(found.intervals[0].end, 1);
  EXPECT_FALSE(found.intervals[0].overlaps);
  EXPECT_EQ(found.intervals[0].overlapVolume, 0);
}

TEST(Collide, SolidsWhoseLivesMeetInAnInstantOnlyTouch) {
  const Mesh a = moved(fixtures::cube(2), along({0, 0, 0}));
  for (const double x : {0, 1, 2}) {
    const TriangleMesh next = fixtures::translated(fixtures::cube(x == 0 ? 1 : 2), {x, 0, 0});
    const Collision found = collided(a, moved(next, along({0, 0, 0}), 1, 1, 1));
    ASSERT_EQ(found.intervals.size(), 1U);
    EXPECT_EQ(found.intervals[0].begin, 1);
    EXPECT_EQ(found.intervals[0].end, 1);
    EXPECT_FALSE(found.intervals[0].overlaps);
  }
}

TEST(Collide, AMoteInACornerOverlaps) {
  const Mesh large = moved(fixtures::cube(2), along({0, 1, 0}));
  const Mesh mote = moved(fixtures::cube(2e-5), along({0, 1, 0}));
  for (const bool swapped : {false, true}) {
    const Collision found = swapped ? collided(mote, large) : collided(large, mote);
    ASSERT_EQ(found.intervals.size(), 1U);
    EXPECT_TRUE(found.intervals[0].overlaps);
    EXPECT_NEAR(found.intervals[0].overlapVolume, 8e-15, 1e-17);
  }
}

TEST(Collide, ABulletThatPassesAPlateBetweenTwoFramesIsCaught) {
  const Mesh bullet = moved(fixtures::icosphere(0.1, 2), along({0, 0, -20}), 1, 1);
  TriangleMesh plate = fixtures::cube(2);
  for (auto& vertex : plate.vertices) vertex.z() = 0.005 * vertex.z() - 5.3;
  const Mesh b = moved(plate, along({0, 0, 0}));
  const Collision found = collided(bullet, b);
  ASSERT_EQ(found.intervals.size(), 1U);
  EXPECT_NEAR(found.intervals[0].begin, (5.295 - 0.1) / 20, 1e-12);
  EXPECT_NEAR(found.intervals[0].end, (5.305 + 0.1) / 20, 1e-12);
  EXPECT_TRUE(found.intervals[0].overlaps);
}

TEST(Collide, ASolidInsideAnotherIsFoundWithoutCrossingSurfaces) {
  const Mesh small = moved(fixtures::cube(1), along({0.5, 0, 0}), 1, 2);
  const Mesh large = moved(fixtures::cube(4), along({0, 0, 0}), 1, 3);
  for (const bool swapped : {false, true}) {
    const Collision found = swapped ? collided(large, small) : collided(small, large);
    ASSERT_EQ(found.intervals.size(), 1U);
    EXPECT_EQ(found.intervals[0].begin, 0);
    EXPECT_EQ(found.intervals[0].end, 1);
    EXPECT_TRUE(found.intervals[0].overlaps);
    EXPECT_NEAR(found.intervals[0].overlapVolume, 1, 0.01);
    // The cell is one of the solid inside.
    EXPECT_EQ(found.intervals[0].first.a.has_value(), !swapped);
    EXPECT_EQ(found.intervals[0].first.b.has_value(), swapped);
  }
}

TEST(Collide, ASolidInACavityIsClear) {
  const Mesh small = moved(fixtures::cube(1), along({0.25, 0, 0}), 1, 2);
  const Mesh hollow = moved(fixtures::hollowCube(4, 2), along({0, 0, 0}), 1, 3);
  const Collision found = collided(small, hollow);
  EXPECT_TRUE(found.intervals.empty());
  ASSERT_TRUE(found.clearance);
  EXPECT_NEAR(found.clearance->distance, 0.25, 1e-12);
  EXPECT_LE(found.clearance->lowerBound, found.clearance->distance);
  EXPECT_NEAR(found.clearance->lowerBound, 0.25, 1e-8);
  EXPECT_NEAR(found.clearance->time, 1, 1e-12);
}

TEST(Collide, BallsThatPassEachOtherComeAsNearAsTheirPathsSay) {
  // Octahedra: corners on the axes, so the nearest points are known.
  const TriangleMesh ball = fixtures::bipyramid(4);
  const Mesh a = moved(ball, along({8, 0, 0}), 2, 3);
  const Mesh b = moved(fixtures::translated(ball, {4, 0, 3}), along({0, 0, 0}), 2, 2);
  const Collision found = collided(a, b, {.clearanceOverTime = true});
  EXPECT_TRUE(found.intervals.empty());
  ASSERT_TRUE(found.clearance);
  EXPECT_NEAR(found.clearance->distance, 1, 1e-12);
  EXPECT_NEAR(found.clearance->time, 1, 1e-9);
  EXPECT_EQ(found.clearanceOverTime.size(), 4U);
}

TEST(Collide, ABarTurnsIntoAPost) {
  TriangleMesh bar = fixtures::cube(2);
  for (auto& vertex : bar.vertices) vertex = {5 * vertex.x() + 5, 0.25 * vertex.y(), vertex.z()};
  const Mesh a = moved(bar, about(Vector3d::UnitZ(), 90), 90, 90);
  TriangleMesh post = fixtures::translated(fixtures::cube(0.5), {0, 8, 0});
  const Mesh b = moved(post, along({0, 0, 0}), 90, 1);
  const Collision found = collided(a, b);
  ASSERT_EQ(found.intervals.size(), 1U);
  // The bar's upper face y = 0.25 meets the corner (0.25, 7.75): the distance 0.25 from the axis
  // along the bar's normal.
  const double radius = std::hypot(0.25, 7.75);
  const double angle = std::atan2(7.75, 0.25) - std::asin(0.25 / radius);
  // Between layers, the mesh is within this of the true bar; the longest edge is its diagonal.
  const double half = 0.5 * std::numbers::pi / 180;
  const double bound =
      std::hypot(10, 0.25) * (1 - std::cos(half)) + std::hypot(10, 2) * std::sin(half) / 6;
  EXPECT_NEAR(found.intervals[0].begin, angle * 180 / std::numbers::pi,
              bound / 7.75 * 180 / std::numbers::pi);
}

TEST(CollisionVerdict, IsTheSameOfTheBodiesExchanged) {
  // A bar whose end reaches into a post after a quarter turn, by less or by more than its chords
  // are off.
  TriangleMesh bar = fixtures::cube(2);
  for (auto& vertex : bar.vertices) vertex = {5 * vertex.x() + 5, 1.5 * vertex.y(), vertex.z()};
  const Mesh turning = moved(bar, about(Vector3d::UnitZ(), 90), 1, 8);
  std::set<Verdict> seen;
  for (const double depth : {-1.0, 0.2, 2.0}) {
    SCOPED_TRACE(depth);
    const Mesh still =
        moved(fixtures::translated(fixtures::cube(4), {0, 12 - depth, 0}), along({0, 0, 0}));
    const Collision one = collided(turning, still);
    const Collision other = collided(still, turning);
    const auto verdict = verdictOn(one, turning, still);
    const auto exchanged = verdictOn(other, still, turning);
    ASSERT_TRUE(verdict && exchanged);
    seen.insert(verdict->verdict);
    EXPECT_EQ(exchanged->verdict, verdict->verdict);
    EXPECT_EQ(exchanged->chordBound, verdict->chordBound);
    EXPECT_EQ(exchanged->chordsA->bound, verdict->chordsB->bound);
    EXPECT_NEAR(exchanged->depth, verdict->depth, 0.02 * verdict->depth);
    EXPECT_NEAR(exchanged->clearBy, verdict->clearBy, 1e-6);
    EXPECT_EQ(exchanged->minVolumeRatio.has_value(), verdict->minVolumeRatio.has_value());
    EXPECT_NEAR(exchanged->minVolumeRatio.value_or(1), verdict->minVolumeRatio.value_or(1), 1e-6);
    for (const double distance : {0.1, 0.8, 1.5}) {
      const auto kept = clearanceVerdict(one, *verdict, distance);
      const auto keptExchanged = clearanceVerdict(other, *exchanged, distance);
      EXPECT_EQ(keptExchanged.answer, kept.answer);
      EXPECT_NEAR(keptExchanged.minVolumeRatio.value_or(1), kept.minVolumeRatio.value_or(1), 1e-6);
    }
  }
  EXPECT_EQ(seen, (std::set{Verdict::Hit, Verdict::Clear, Verdict::WithinTolerance}));
}

TEST(CollisionVerdict, WidePlatesThatOverlapByARoundingOfTheirWidthTouch) {
  // One on the other; rounding is that of their far corner, though the near one is at the origin.
  for (const auto& [overlap, expected] : {std::pair{1e-9, Verdict::Touch}, {1e-3, Verdict::Hit}}) {
    const auto plate = [](double from, double to) {
      TriangleMesh mesh = fixtures::cube(1);
      for (auto& vertex : mesh.vertices) {
        vertex = {1e7 * (vertex.x() + 0.5), 1e7 * (vertex.y() + 0.5), vertex.z() < 0 ? from : to};
      }
      return mesh;
    };
    const Mesh lower = moved(plate(-1, overlap), along({0, 0, 0}));
    const Mesh upper = moved(plate(0, 1), along({0, 0, 0}));
    const auto verdict = verdictOn(collided(lower, upper), lower, upper);
    ASSERT_TRUE(verdict);
    EXPECT_EQ(verdict->verdict, expected) << overlap;
  }
}

TEST(CollisionVerdict, DepthIsThatOfTheDeepestPointWhereverItLies) {
  // The corner of a cube in a ball: the deepest point is as far from the ball as from the faces,
  // and the middle of what both boxes have in common is outside of the ball.
  const TriangleMesh ball = fixtures::icosphere(2, 4);
  const Mesh round = moved(ball, along({0, 0, 0}));
  const Mesh cube =
      moved(fixtures::translated(fixtures::cube(4), {2.5, 2.5, 2.5}), along({0, 0, 0}));
  const auto verdict = verdictOn(collided(round, cube), round, cube);
  ASSERT_TRUE(verdict);
  EXPECT_EQ(verdict->verdict, Verdict::Hit);
  EXPECT_NEAR(verdict->depth, 2.5 / (1 + std::sqrt(3)) - 0.5, 0.03 * 0.415);
}

/// Moves a mesh by one translation after another, each for its duration.
Mesh movedAlong(const TriangleMesh& mesh, const std::vector<std::pair<double, Vector3d>>& moves) {
  std::vector<model::ScrewRun> runs;
  for (const auto& [duration, by] : moves) runs.push_back({duration, along(by), 1});
  const auto motion = model::chainScrews(0, runs);
  Mesh made;
  EXPECT_TRUE(mesh4d::sweep(mesh, *motion, {.caps = mesh4d::CapMethod::Cone}, made));
  return made;
}

TriangleMesh placed(TriangleMesh mesh, const Eigen::Isometry3d& place) {
  for (auto& vertex : mesh.vertices) vertex = place * vertex;
  return mesh;
}

TEST(CollisionVerdict, ATipThatDipsInAndLeavesIsAHitAsDeepAsItDips) {
  // An octahedron above a table: its tip, whose section d below is a square of the area 2 d^2, goes
  // down by `height` and `dip`, and up again.
  std::mt19937 random(48);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution(low, high)(random);
  };
  TriangleMesh table = fixtures::cube(4);
  for (auto& vertex : table.vertices) vertex.z() = 0.1 * vertex.z() - 0.2;
  const TriangleMesh tip = fixtures::translated(fixtures::bipyramid(4), {0, 0, 1});
  for (int k = 1; k <= 6; ++k) {
    for (int trial = 0; trial < 3; ++trial) {
      const double dip = between(0.5, 1.5) * std::pow(10, -k);
      const double height = between(0.05, 0.5);
      const double down = between(0.1, 3);
      const double up = between(0.1, 3);
      SCOPED_TRACE(testing::Message() << "dip " << dip << " after " << down);
      const Eigen::Isometry3d place =
          Eigen::Translation3d(between(-5, 5), between(-5, 5), between(-5, 5)) *
          Eigen::AngleAxisd(between(-3, 3), Vector3d(1, between(-1, 1), 0.3).normalized());
      const Vector3d way = place.linear() * Vector3d(0, 0, height + dip);
      const Vector3d start(between(-1.5, 1.5), between(-1.5, 1.5), height);
      const Mesh a =
          movedAlong(placed(fixtures::translated(tip, start), place), {{down, -way}, {up, way}});
      const Mesh b = movedAlong(placed(table, place), {{down + up, {0, 0, 0}}});
      const Collision found = collided(a, b);
      ASSERT_EQ(found.intervals.size(), 1U);
      const ContactInterval& interval = found.intervals[0];
      EXPECT_TRUE(interval.overlaps);
      const double part = dip / (height + dip);
      EXPECT_NEAR(interval.begin, down * (1 - part), 1e-8 * down);
      EXPECT_NEAR(interval.end, down + up * part, 1e-8 * up);
      EXPECT_NEAR(interval.deepestTime, down, 1e-3 * part * (down + up));
      const double volume = 2 * dip * dip * dip / 3;
      EXPECT_NEAR(interval.overlapVolume, volume, 0.01 * volume);
      const auto verdict = verdictOn(found, a, b);
      ASSERT_TRUE(verdict);
      EXPECT_EQ(verdict->verdict, Verdict::Hit);
      // A point in both that is as far from the table's face as from the octahedron's, which are
      // inclined by 1 / sqrt(3).
      const double depth = dip / (1 + std::numbers::sqrt3);
      EXPECT_LE(verdict->depth, depth * (1 + 1e-6));
      EXPECT_GE(verdict->depth, depth / 1.03);
      EXPECT_EQ(clearanceVerdict(found, *verdict, 0).answer, ClearanceVerdict::Answer::NotKept);
    }
  }
}

TEST(CollisionVerdict, AShortDipDuringALongTouchIsAHit) {
  // A cube rests on another one, goes into it by 1e-4 and back within a hundredth of the time.
  const double dip = 1e-4;
  const Mesh a =
      movedAlong(fixtures::translated(fixtures::cube(2), {0.5, 0.25, 2}),
                 {{7, {0, 0, 0}}, {0.05, {0, 0, -dip}}, {0.05, {0, 0, dip}}, {2.9, {0.125, 0, 0}}});
  const Mesh b = moved(fixtures::cube(2), along({0, 0, 0}), 10);
  const Collision found = collided(a, b);
  ASSERT_EQ(found.intervals.size(), 1U);
  EXPECT_EQ(found.intervals[0].begin, 0);
  EXPECT_EQ(found.intervals[0].end, 10);
  EXPECT_NEAR(found.intervals[0].deepestTime, 7.05, 1e-4);
  EXPECT_NEAR(found.intervals[0].overlapVolume, 1.5 * 1.75 * dip, 0.01 * dip);
  const auto verdict = verdictOn(found, a, b);
  ASSERT_TRUE(verdict);
  EXPECT_EQ(verdict->verdict, Verdict::Hit);
  EXPECT_NEAR(verdict->depth, dip / 2, 0.03 * dip);
}

/// A mesh whose slabs cannot be read.
class Unreadable : public model::Source {
 public:
  explicit Unreadable(const Mesh& mesh) : mesh_(mesh) {}
  std::size_t slabCount() const override { return mesh_.slabCount(); }
  model::TimeSpan timeSpan(std::size_t index) const override { return mesh_.timeSpan(index); }
  Result<std::shared_ptr<const model::Slab>> slab(std::size_t) const override {
    return fail(ErrorCode::Io, "cannot be read");
  }

 private:
  const Mesh& mesh_;
};

TEST(Collide, OverlapsOfWhatCannotBeReadFail) {
  const Mesh cube = moved(fixtures::cube(2), along({1, 0, 0}));
  const Unreadable broken(cube);
  ContactInterval interval;
  interval.end = 1;
  const auto measured = measureOverlaps(cube, broken, {&interval, 1});
  ASSERT_FALSE(measured);
  EXPECT_EQ(measured.error().message, "cannot be read");
  EXPECT_FALSE(overlapVolumes(broken, cube, std::vector<double>{0.5}));
  EXPECT_FALSE(collide(cube, broken));
  EXPECT_FALSE(verdictOn(collided(cube, cube), broken, cube));
}

TEST(Collide, BodiesThatNeverExistTogetherHaveNoClearance) {
  const Mesh a = moved(fixtures::cube(2), along({3, 0, 0}));
  const Mesh b = moved(fixtures::cube(2), along({3, 0, 0}), 1, 1, 2);
  const Collision found = collided(a, b);
  EXPECT_FALSE(found.common);
  EXPECT_FALSE(found.contact());
  EXPECT_FALSE(found.clearance);
}

void expectSame(const Collision& a, const Collision& b) {
  const auto sameCell = [](const std::optional<CellNumber>& p, const std::optional<CellNumber>& q) {
    ASSERT_EQ(p.has_value(), q.has_value());
    if (!p) return;
    EXPECT_EQ(p->slab, q->slab);
    EXPECT_EQ(p->cell, q->cell);
  };
  ASSERT_EQ(a.intervals.size(), b.intervals.size());
  for (std::size_t i = 0; i < a.intervals.size(); ++i) {
    const ContactInterval& p = a.intervals[i];
    const ContactInterval& q = b.intervals[i];
    EXPECT_EQ(
        std::tuple(p.begin, p.end, p.overlaps, p.deepestTime, p.overlapVolume, p.volumeError),
        std::tuple(q.begin, q.end, q.overlaps, q.deepestTime, q.overlapVolume, q.volumeError));
    EXPECT_EQ(p.first.point, q.first.point);
    sameCell(p.first.a, q.first.a);
    sameCell(p.first.b, q.first.b);
  }
  ASSERT_EQ(a.clearance.has_value(), b.clearance.has_value());
  if (a.clearance) {
    EXPECT_EQ(std::tuple(a.clearance->distance, a.clearance->lowerBound, a.clearance->time),
              std::tuple(b.clearance->distance, b.clearance->lowerBound, b.clearance->time));
    EXPECT_EQ(a.clearance->pointA, b.clearance->pointA);
    EXPECT_EQ(a.clearance->pointB, b.clearance->pointB);
    sameCell(a.clearance->a, b.clearance->a);
    sameCell(a.clearance->b, b.clearance->b);
  }
  ASSERT_EQ(a.clearanceOverTime.size(), b.clearanceOverTime.size());
  for (std::size_t i = 0; i < a.clearanceOverTime.size(); ++i) {
    EXPECT_EQ(a.clearanceOverTime[i].distance, b.clearanceOverTime[i].distance);
  }
}

TEST(Collide, DoesNotDependOnTheNumberOfThreads) {
  const TriangleMesh ring = fixtures::torus(3, 1, 16, 8);
  const Mesh a = moved(ring, about({1, 2, 3}, 90), 1, 12);
  for (const double x : {3.5, 12.0}) {
    const Mesh b = moved(fixtures::translated(fixtures::pebble(1.5, 120), {x, 0, 0}),
                         about({0, 0, 1}, 40), 1, 7);
    const auto with = [&](int threads) {
      const model::ThreadLimit control(threads);
      return collided(a, b, {.clearanceOverTime = true});
    };
    const Collision one = with(1);
    EXPECT_EQ(one.contact(), x < 10);
    expectSame(one, with(2));
    expectSame(one, with(4));
  }
}

/// A bolt with a coarse thread for some turns, and its nut, which is 0.5 wider.
struct BoltAndNut {
  explicit BoltAndNut(double turns) : turns(turns) {
    bolt.pitch = 3;
    bolt.length = bolt.threadLength = 18 + turns * bolt.pitch;
    bolt.segments = 12;
    nut.clearance = 0.5;
    nut.height = 9;
    fixed = moved(fixtures::nutWithThread(bolt, nut), along({0, 0, 0}), turns, 1);
  }

  /// The bolt is screwed in, in a unit of time per turn, with four layers for each column.
  Mesh screwed(double pitch) const {
    Screw screw = about(Vector3d::UnitZ(), -360 * turns);
    screw.translation.z() = -pitch * turns;
    return moved(fixtures::boltWithThread(bolt), screw, turns,
                 static_cast<std::uint64_t>(4 * bolt.segments * turns));
  }

  /// How much nearer to each other, along the radius, chords around the threads bring them.
  double sagitta() const {
    return (0.5 * bolt.diameter + nut.clearance) * (1 - std::cos(std::numbers::pi / bolt.segments));
  }

  double turns;
  fixtures::BoltOptions bolt;
  fixtures::NutOptions nut;
  Mesh fixed;
};

void expectClearOver(double turns) {
  const BoltAndNut pair(turns);
  EXPECT_FALSE(collided(pair.screwed(pair.bolt.pitch), pair.fixed, {.clearance = false}).contact());
}

TEST(Collide, ABoltInItsNutIsClear) { expectClearOver(0.5); }

TEST(Collide, ABoltInItsNutIsClearOverFiveTurns) { expectClearOver(5); }

TEST(Collide, ABoltKeepsItsClearanceInItsNut) {
  const BoltAndNut pair(1.0 / 6);
  const Mesh bolt = pair.screwed(pair.bolt.pitch);
  const Collision found = collided(bolt, pair.fixed);
  ASSERT_TRUE(found.clearance);
  const auto verdict = verdictOn(found, bolt, pair.fixed);
  ASSERT_TRUE(verdict && verdict->chordBound);
  EXPECT_EQ(verdict->verdict, Verdict::Clear);
  // Flanks at 60 degrees to the radius.
  EXPECT_LE(found.clearance->distance, pair.nut.clearance / 2 + 1e-12);
  EXPECT_GE(found.clearance->lowerBound,
            (pair.nut.clearance - pair.sagitta()) / 2 - *verdict->chordBound);
}

TEST(Collide, ABoltAtTheWrongPitchMeetsItsNutAtTheRightTime) {
  const BoltAndNut pair(1);
  const double lead = 0.6;  // more than the pitch, per turn
  for (const double sign : {-1.0, 1.0}) {
    const Mesh bolt = pair.screwed(pair.bolt.pitch + sign * lead);
    const Collision found = collided(bolt, pair.fixed, {.clearance = false});
    const auto bound = chordBound(bolt, {0, 1});
    ASSERT_TRUE(bound && *bound);
    // Columns come and go, so that the first contacts may be short.
    ASSERT_TRUE(found.contact());
    EXPECT_TRUE(found.intervals.back().overlaps);
    // Where columns of the two meshes meet, both are exact.
    const double time = pair.nut.clearance / std::numbers::sqrt3 / lead;
    EXPECT_LE(found.intervals[0].begin,
              std::ceil(time * pair.bolt.segments) / pair.bolt.segments + 1e-12);
    EXPECT_GE(found.intervals[0].begin,
              time - (pair.sagitta() + 2 * (*bound)->bound) / std::numbers::sqrt3 / lead);
    EXPECT_EQ(found.intervals.back().end, 1);
  }
}

}  // namespace
}  // namespace t4d::measure
