#include "t4d/measure/collide.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "t4d/fixtures/solids.h"
#include "t4d/mesh4d/sweep.h"
#include "t4d/model/motion.h"

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

TriangleMesh turned(TriangleMesh mesh, const Vector3d& axis, double degrees) {
  const Eigen::AngleAxisd turn(degrees * std::numbers::pi / 180, axis.normalized());
  for (auto& vertex : mesh.vertices) vertex = turn * vertex;
  return mesh;
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

TEST(Collide, CubesMeetEdgeToEdgeAndVertexToFace) {
  const TriangleMesh edgeUp = turned(fixtures::cube(2), Vector3d::UnitZ(), 45);
  const Mesh a = moved(edgeUp, along({1, 0, 0}));
  const Mesh b = moved(fixtures::translated(turned(edgeUp, Vector3d::UnitX(), 90), {4, 0, 0}),
                       along({-1, 0, 0}));
  const Collision edges = collided(a, b);
  ASSERT_EQ(edges.intervals.size(), 1U);
  EXPECT_NEAR(edges.intervals[0].begin, (4 - 2 * std::numbers::sqrt2) / 2, 1e-12);
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

TEST(Collide, BodiesThatNeverExistTogetherHaveNoClearance) {
  const Mesh a = moved(fixtures::cube(2), along({3, 0, 0}));
  const Mesh b = moved(fixtures::cube(2), along({3, 0, 0}), 1, 1, 2);
  const Collision found = collided(a, b);
  EXPECT_FALSE(found.common);
  EXPECT_FALSE(found.contact());
  EXPECT_FALSE(found.clearance);
}

}  // namespace
}  // namespace t4d::measure
