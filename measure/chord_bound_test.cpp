#include "measure/chord_bound.h"

#include <cmath>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "measure/collision_verdict.h"
#include "measure/triangle_tree.h"
#include "mesh4d/test_motion.h"
#include "t4d/mesh.h"
#include "t4d/slice.h"
#include "t4d/sweep.h"

namespace t4d::measure {
namespace {

using Eigen::Vector3d;
using model::TriangleMesh;

model::Mesh swept(const TriangleMesh& mesh, const model::Motion& motion,
                  const mesh4d::SweepOptions& options) {
  model::Mesh made;
  const auto report = mesh4d::sweep(mesh, motion, options, made);
  EXPECT_TRUE(report) << report.error().text();
  return made;
}

/// The farthest that a vertex of `mesh` is from `other`.
double farthest(const TriangleMesh& mesh, const TriangleMesh& other) {
  const TriangleTree tree(other);
  double most = 0;
  for (const auto& vertex : mesh.vertices) most = std::max(most, tree.nearest(vertex).distance);
  return most;
}

TEST(ChordBound, HoldsBetweenLayersForAnyStepAndSplit) {
  const TriangleMesh solid = fixtures::translated(fixtures::cube(2), {3, 1, 0});
  for (const auto split : {mesh4d::PrismSplit::Fourteen, mesh4d::PrismSplit::Three}) {
    for (const double degrees : {10.0, 45.0, 90.0}) {
      SCOPED_TRACE(degrees);
      model::ScrewRun run;
      run.screw = {{0.5, 0, 0}, Vector3d(1, 2, 3).normalized(), degrees, {0.3, 0.6, 0.9}};
      run.duration = 1;
      const auto moved = model::chainScrews(0, {&run, 1});
      ASSERT_TRUE(moved);
      const model::Mesh mesh =
          swept(solid, *moved, {.steps = mesh4d::StepsPerSegment{1}, .prism = split});
      const auto bound = chordBound(mesh, {0, 1});
      ASSERT_TRUE(bound && *bound);
      EXPECT_NEAR((*bound)->angleRadians, degrees * std::acos(-1) / 180, 1e-12);
      double worst = 0;
      for (int k = 0; k <= 20; ++k) {
        TriangleMesh posed = solid;
        for (auto& vertex : posed.vertices) vertex = moved->at(k / 20.0)(vertex);
        const auto slice = slice::sliceAtTime(mesh, k / 20.0);
        ASSERT_TRUE(slice);
        worst = std::max({worst, farthest(slice->mesh, posed), farthest(posed, slice->mesh)});
      }
      EXPECT_LE(worst, (*bound)->bound);
      EXPECT_GT(worst, 0.2 * (*bound)->bound);
    }
  }
}

TEST(ChordBound, IsZeroForTranslationsAndUnknownForVoxelsAndDeformations) {
  model::ScrewRun run;
  run.duration = 2;
  run.screw.translation = {1, 2, 3};
  const auto motion = model::chainScrews(0, {&run, 1});
  const model::Mesh mesh = swept(fixtures::cube(2), *motion, {});
  double last = 0;
  const auto bound = chordBound(mesh, {0, 2}, {}, [&](double part) {
    EXPECT_GT(part, last);
    last = part;
    return true;
  });
  ASSERT_TRUE(bound && *bound);
  EXPECT_EQ((*bound)->bound, 0);
  EXPECT_EQ(last, 1);
  model::Mesh unknown;
  for (model::Slab slab : mesh.slabs()) {
    slab.upperPose = nullptr;
    ASSERT_TRUE(unknown.put(slab));
  }
  const auto none = chordBound(unknown, {0, 2});
  ASSERT_TRUE(none);
  EXPECT_FALSE(*none);
}

/// A whole turn in one step has equal poses at both ends, three quarters those of a quarter.
TEST(ChordBound, IsUnknownIfAStepTurnsByMoreThanHalfATurn) {
  const TriangleMesh solid = fixtures::cube(2);
  for (const double degrees : {180.0, 181.0, 270.0, -360.0, 720.0}) {
    SCOPED_TRACE(degrees);
    std::array<model::ScrewRun, 2> runs;
    for (model::ScrewRun& run : runs) run.duration = 1;
    runs[0].screw.translation = {1, 0, 0};
    runs[1].screw = {{3, 0, 0}, Vector3d::UnitZ(), degrees, {0, 0, 1}};
    const auto motion = model::chainScrews(0, runs);
    const model::Mesh mesh = swept(solid, *motion, {.steps = mesh4d::StepsPerSegment{1}});
    const auto bound = chordBound(mesh, {0, 2});
    ASSERT_TRUE(bound);
    EXPECT_EQ(bound->has_value(), degrees == 180);
    const model::Mesh finer = swept(solid, *motion, {.steps = mesh4d::StepsPerSegment{4}});
    EXPECT_TRUE(*chordBound(finer, {0, 2}));
  }
}

TEST(ChordBound, OfAPartIsThatOfTheWhole) {
  for (const double degrees : {0.0, 90.0}) {
    model::ScrewRun run;
    run.screw = {{0.5, 0, 0}, Vector3d::UnitY(), degrees, {0.3, 0.6, 0.9}};
    run.duration = 3;
    const auto motion = model::chainScrews(0, {&run, 1});
    ASSERT_TRUE(motion);
    const model::Mesh whole =
        swept(fixtures::cube(2), *motion, {.steps = mesh4d::StepsPerSegment{3}});
    model::Mesh part;
    for (model::Slab slab : whole.slabs()) {
      if (slab.timeEnd == 3) slab.upperPose = nullptr;
      if (slab.timeEnd <= 1 || slab.timeEnd == slab.timeBegin) continue;
      ASSERT_TRUE(part.put(slab));
    }
    const auto ofWhole = chordBound(whole, {1, 3});
    const auto ofPart = chordBound(part, {1, 3});
    ASSERT_TRUE(ofWhole && *ofWhole && ofPart && *ofPart);
    EXPECT_NEAR((*ofPart)->bound, (*ofWhole)->bound, 1e-12);
    EXPECT_EQ((*ofPart)->bound == 0, degrees == 0);
  }
}

TEST(ChordBound, ScalesWithAMeshThatIsScaled) {
  const model::Mesh mesh =
      swept(fixtures::cube(2), mesh4d::turnAbout(Vector3d(1, 2, 3).normalized(), 100), {});
  const auto whole = chordBound(mesh, {0, 1});
  ASSERT_TRUE(whole && *whole);
  const Eigen::AngleAxisd turn(0.7, Vector3d(2, -1, 1).normalized());
  for (const double scale : {1e-3, 0.5, 1e3}) {
    model::Transform by;
    by.space << scale * turn.toRotationMatrix(), Vector3d(1, 2, 3);
    model::Mesh scaled;
    model::Transformed into(scaled, by);
    ASSERT_TRUE(model::pump(mesh, into));
    const auto found = chordBound(scaled, {0, 1});
    ASSERT_TRUE(found && *found) << scale;
    EXPECT_NEAR((*found)->bound / (scale * (*whole)->bound), 1, 1e-9) << scale;
  }
  // Scaled along an axis it does not turn rigidly.
  model::Transform by;
  by.space << Vector3d(1, 2, 1).asDiagonal().toDenseMatrix(), Vector3d::Zero();
  model::Mesh scaled;
  model::Transformed into(scaled, by);
  ASSERT_TRUE(model::pump(mesh, into));
  const auto found = chordBound(scaled, {0, 1});
  ASSERT_TRUE(found);
  EXPECT_FALSE(*found);
}

TEST(CollisionVerdict, NamesTheStepsThatDecide) {
  TriangleMesh bar = fixtures::cube(2);
  for (auto& vertex : bar.vertices) vertex = {10 * vertex.x(), 0.25 * vertex.y(), vertex.z()};
  const model::Motion turn = mesh4d::turnAbout(Vector3d::UnitZ(), 180);
  // The bar's tip comes as near as 0.1 to the wall.
  TriangleMesh wall = fixtures::cube(2);
  for (auto& vertex : wall.vertices) {
    vertex = {20 * vertex.x(), vertex.y() + 1.1 + std::hypot(10, 0.25), 2 * vertex.z()};
  }
  const model::Motion rest = mesh4d::turnAbout(Vector3d::UnitZ(), 0);
  const model::Mesh still = swept(wall, rest, {});

  const model::Mesh coarse = swept(bar, turn, {.steps = mesh4d::StepsPerSegment{7}});
  const auto unsure = collide(coarse, still);
  ASSERT_TRUE(unsure);
  const auto verdict = verdictOn(*unsure, coarse, still);
  ASSERT_TRUE(verdict);
  EXPECT_EQ(verdict->verdict, Verdict::WithinTolerance);
  ASSERT_TRUE(verdict->minVolumeRatio);

  // The coarse bar is farther from the wall than the true one, so the first may not be enough.
  auto clear = verdict;
  for (int round = 0; round < 3 && clear->minVolumeRatio; ++round) {
    const model::Mesh fine =
        swept(bar, turn, {.steps = mesh4d::MinVolumeRatio{*clear->minVolumeRatio}});
    const auto sure = collide(fine, still);
    ASSERT_TRUE(sure);
    clear = verdictOn(*sure, fine, still);
    ASSERT_TRUE(clear);
  }
  EXPECT_EQ(clear->verdict, Verdict::Clear);
  EXPECT_GT(clear->clearBy, 0);
  EXPECT_LE(clear->clearBy, 0.1);
}

TEST(CollisionVerdict, SaysHitForWhatIsDeeperThanTheBound) {
  const model::Mesh a = swept(fixtures::cube(4), mesh4d::turnAbout(Vector3d::UnitZ(), 90), {});
  const model::Mesh b = swept(fixtures::translated(fixtures::cube(2), {2, 0, 0}),
                              mesh4d::turnAbout(Vector3d::UnitZ(), 0), {});
  const auto found = collide(a, b);
  ASSERT_TRUE(found);
  const auto verdict = verdictOn(*found, a, b);
  ASSERT_TRUE(verdict);
  EXPECT_EQ(verdict->verdict, Verdict::Hit);
  ASSERT_TRUE(verdict->chordBound);
  EXPECT_GT(verdict->depth, *verdict->chordBound);
}

TEST(ClearanceVerdict, NeverContradictsTheTrueDistance) {
  // A bar that turns before a wall: its tip comes as near as 0.1 whatever the steps.
  TriangleMesh bar = fixtures::cube(2);
  for (auto& vertex : bar.vertices) vertex = {10 * vertex.x(), 0.25 * vertex.y(), vertex.z()};
  TriangleMesh wall = fixtures::cube(2);
  constexpr double kTrue = 0.1;
  for (auto& vertex : wall.vertices) {
    vertex = {20 * vertex.x(), vertex.y() + 1 + kTrue + std::hypot(10, 0.25), 2 * vertex.z()};
  }
  const model::Mesh still = swept(wall, mesh4d::turnAbout(Vector3d::UnitZ(), 0), {});
  using Answer = ClearanceVerdict::Answer;
  for (const std::uint64_t steps : {7U, 40U, 300U}) {
    const model::Mesh turning = swept(bar, mesh4d::turnAbout(Vector3d::UnitZ(), 180),
                                      {.steps = mesh4d::StepsPerSegment{steps}});
    const auto found = collide(turning, still);
    ASSERT_TRUE(found);
    const auto verdict = verdictOn(*found, turning, still);
    ASSERT_TRUE(verdict);
    for (const double factor : {0.0, 0.5, 0.9, 0.999, 1.001, 1.1, 2.0, 10.0}) {
      SCOPED_TRACE(factor);
      const auto clearance = clearanceVerdict(*found, *verdict, factor * kTrue);
      EXPECT_LE(clearance.least, kTrue);
      EXPECT_GE(clearance.most, kTrue);
      EXPECT_EQ(clearance.answer == Answer::Kept, clearance.least >= factor * kTrue);
      EXPECT_EQ(clearance.answer == Answer::NotKept, clearance.most < factor * kTrue);
    }
    EXPECT_EQ(clearanceVerdict(*found, *verdict, 10).answer, Answer::NotKept);
  }
}

TEST(ClearanceVerdict, CountsTheBoundThatIsKnownWhereTheOtherIsNot) {
  const TriangleMesh bar = fixtures::translated(fixtures::cube(2), {3, 0, 0});
  const model::Mesh turning =
      swept(bar, mesh4d::turnAbout(Vector3d::UnitZ(), 90), {.steps = mesh4d::StepsPerSegment{6}});
  model::Mesh unknown;
  const model::Mesh still = swept(fixtures::translated(fixtures::cube(2), {3, 0, 2.2}),
                                  mesh4d::turnAbout(Vector3d::UnitZ(), 0), {});
  for (model::Slab slab : still.slabs()) {
    slab.upperPose = nullptr;
    ASSERT_TRUE(unknown.put(slab));
  }
  const auto found = collide(turning, unknown);
  ASSERT_TRUE(found && found->clearance);
  const auto verdict = verdictOn(*found, turning, unknown);
  ASSERT_TRUE(verdict);
  EXPECT_FALSE(verdict->chordBound);
  ASSERT_GT(verdict->knownBound(), 0);
  const auto clearance = clearanceVerdict(*found, *verdict, found->clearance->distance);
  EXPECT_NE(clearance.answer, ClearanceVerdict::Answer::Kept);
  EXPECT_EQ(clearance.least, verdict->clearBy);
}

}  // namespace
}  // namespace t4d::measure
