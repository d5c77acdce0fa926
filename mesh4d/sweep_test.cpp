#include "t4d/sweep.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "mesh4d/steps.h"
#include "mesh4d/test_motion.h"
#include "t4d/check.h"
#include "t4d/mesh.h"

namespace t4d::mesh4d {
namespace {

/// With cones at both ends, so TetGen is not needed.
SweepOptions options(const StepRule& steps = MinVolumeRatio{}) {
  return {steps, CapMethod::Cone, PrismSplit::Fourteen};
}

TEST(Sweep, InsideOutMeshIsTurnedRoundWithANotice) {
  model::TriangleMesh mesh = fixtures::cube(2);
  for (model::Triangle& triangle : mesh.triangles) std::swap(triangle[0], triangle[1]);
  model::Mesh swept;
  const auto report = sweep(mesh, turnAbout(Eigen::Vector3d::UnitX(), 10), options(), swept);
  ASSERT_TRUE(report) << report.error().text();
  ASSERT_EQ(report->notices.size(), 2U);
  EXPECT_NE(report->notices[0].find("inside out"), std::string::npos);
  EXPECT_GT(measure::checkMesh(swept)->hypervolume, 0);
}

TEST(Sweep, AttributesOfAnInsideOutMeshAreTurnedRoundWithItsTriangles) {
  model::TriangleMesh mesh = fixtures::cube(2);
  std::vector<std::uint16_t> corners;
  std::vector<std::int32_t> threes;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (const std::uint32_t vertex : mesh.triangles[i]) {
      // Two numbers for each corner.
      corners.push_back(static_cast<std::uint16_t>(i));
      corners.push_back(static_cast<std::uint16_t>(100 + vertex));
      threes.push_back(static_cast<std::int32_t>(threes.size()));
    }
  }
  mesh.attributes = {model::makeAttribute("uv:corners", model::Domain::Cell, corners),
                     model::makeAttribute("normal", model::Domain::Cell, threes)};
  mesh.attributes[0].components = 6;
  mesh.attributes[1].components = 3;
  model::TriangleMesh inside = mesh;
  for (model::Triangle& triangle : inside.triangles) std::swap(triangle[1], triangle[2]);
  for (std::size_t i = 0; i < corners.size(); i += 6) {
    std::swap_ranges(corners.begin() + i + 2, corners.begin() + i + 4, corners.begin() + i + 4);
  }
  inside.attributes[0] = model::makeAttribute("uv:corners", model::Domain::Cell, corners);
  inside.attributes[0].components = 6;
  model::Mesh expected;
  model::Mesh found;
  const model::Motion motion = turnAbout(Eigen::Vector3d::UnitX(), 10);
  ASSERT_TRUE(sweep(mesh, motion, options(), expected));
  ASSERT_TRUE(sweep(inside, motion, options(), found));
  ASSERT_EQ(found.slabCount(), expected.slabCount());
  for (std::size_t i = 0; i < found.slabCount(); ++i) {
    EXPECT_EQ(*found.slabs()[i].connectivity, *expected.slabs()[i].connectivity);
  }
}

TEST(Sweep, StopsWhenTold) {
  std::size_t reports = 0;
  model::Mesh swept;
  const auto report =
      sweep(fixtures::cube(2), turnAbout({1, 2, 3}, 300), options(StepsPerSegment{50}), swept,
            [&](double) { return ++reports < 7; });
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().message, "stopped");
  EXPECT_EQ(reports, 7U);
  EXPECT_LT(swept.slabCount(), 12U);
}

TEST(Sweep, LayersHaveTheirPosesButWherePartsMeet) {
  const model::Motion motion = turnAbout({1, 2, 3}, 70);
  for (std::uint64_t number = 1; number <= 3; ++number) {
    SweepOptions part = options(StepsPerSegment{5});
    part.part = {number, 3};
    model::Mesh swept;
    ASSERT_TRUE(sweep(fixtures::cube(2), motion, part, swept));
    for (const model::Slab& slab : swept.slabs()) {
      const bool last = &slab == &swept.slabs().back();
      ASSERT_EQ(slab.upperPose == nullptr, last) << number;
      EXPECT_TRUE(last || slab.upperPose->gives(slab.upperLayer()));
    }
    EXPECT_EQ(swept.slabs().back().connectivity->upperCount == 0, number == 3);
  }
}

TEST(Sweep, StepsOfMoreThanAQuarterTurnAreReported) {
  const auto noticesOf = [](double degrees, std::uint64_t steps) {
    model::Mesh swept;
    return sweep(fixtures::cube(2), turnAbout(Eigen::Vector3d::UnitX(), degrees),
                 options(StepsPerSegment{steps}), swept)
        ->notices;
  };
  EXPECT_EQ(noticesOf(360, 4).size(), 1U);  // that of the cones
  for (const auto& notices : {noticesOf(-360, 3), noticesOf(360, 1)}) {
    ASSERT_EQ(notices.size(), 2U);
    EXPECT_NE(notices[0].find("a step of segment 0 turns by"), std::string::npos);
  }
}

TEST(Sweep, StepsThatLongEdgesAskForAreReported) {
  const model::TriangleMesh cube = fixtures::cube(2);
  const model::Motion motion = turnAbout(Eigen::Vector3d::UnitX(), 360);
  const MaxDeviation near{1e-4};
  model::NullSink sink;
  const auto report = sweep(cube, motion, options(near), sink);
  ASSERT_TRUE(report) << report.error().text();
  std::vector<model::Chords> chords = chordsOf(motion, cube, PrismSplit::Fourteen);
  const double edge = chords[0].edge;
  chords[0].edge /= 10;
  const std::string expected = fmt::format(
      "{} steps, because of long edges: between two layers a slice deviates in proportion to the "
      "longest edge, {:.3g}. With edges a tenth as long, {} steps would do",
      report->steps, edge, (*stepsOf(motion, near, chords))[0]);
  EXPECT_EQ(std::ranges::count(report->notices, expected), 1);
  const auto wider = sweep(cube, motion, options(MaxDeviation{1e-3}), sink);  // fewer than 10,000
  EXPECT_EQ(wider->notices.size() + 1, report->notices.size());
}

TEST(Sweep, ConesAreReported) {
  model::Mesh swept;
  const auto report =
      sweep(fixtures::torus(2, 1, 8, 6), turnAbout(Eigen::Vector3d::UnitX(), 10), options(), swept);
  ASSERT_EQ(report->notices.size(), 1U);
  EXPECT_NE(report->notices[0].find("cones"), std::string::npos);
  // The mesh is not a manifold at the apex over a torus: a warning of the deep check.
  const auto judged = *measure::checkMesh(swept, {.vertexLinks = true});
  EXPECT_TRUE(judged.closed && judged.oriented && judged.valid());
  EXPECT_FALSE(*judged.vertexLinksOk);
  EXPECT_EQ(judged.issues.issues.front().code, "cap-vertex-link");
  EXPECT_EQ(judged.degenerateCells, 0U);
}

TEST(Sweep, SinkThatFailsEndsTheSweep) {
  class Full : public model::Sink {
   public:
    Result<void> put(const model::Slab&) override {
      return fail(ErrorCode::Io, "No space left on device", "disk");
    }
  } full;
  const auto report =
      sweep(fixtures::cube(1), turnAbout(Eigen::Vector3d::UnitX(), 10), options(), full);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().where.text(), "disk");
}

TEST(Sweep, StepsOfADecimalDurationAreAtDecimals) {
  model::ScrewRun run;
  run.duration = 2.1;
  run.screw.translation = {0, 0, 1};
  model::Mesh swept;
  ASSERT_TRUE(sweep(fixtures::cube(1), *model::chainScrews(0, std::span(&run, 1)),
                    options(StepsPerSegment{7}), swept));
  const std::vector<double> layers = {0, 0.3, 0.6, 0.9, 1.2, 1.5, 1.8, 2.1};
  ASSERT_EQ(swept.slabCount(), 9U);
  for (std::size_t i = 0; i < layers.size(); ++i) EXPECT_EQ(swept.timeSpan(i).end, layers[i]);
}

TEST(Sweep, DurationTooShortForItsStepsIsRefused) {
  model::ScrewRun run;
  run.duration = 4e-16;
  run.screw.translation = {1, 0, 0};
  const model::Motion motion = *model::chainScrews(1, std::span(&run, 1));
  model::Mesh swept;
  const auto report = sweep(fixtures::cube(1), motion, options(StepsPerSegment{100}), swept);
  ASSERT_FALSE(report);
  EXPECT_NE(report.error().message.find("too coarse there for 100 steps"), std::string::npos);
  EXPECT_EQ(report.error().remedy, Remedy::Motion);
}

TEST(Sweep, FarPlacesAreRefusedWhereTheShapeIsLost) {
  const auto errorOfShift = [](double shift, double turn) {
    model::ScrewRun run;
    run.duration = 1;
    run.screw.translation = {shift, 0, 0};
    run.screw.axisPoint = {shift, 0, 0};
    run.screw.angleDegrees = turn;
    model::Mesh swept;
    const auto report = sweep(fixtures::cube(2), *model::chainScrews(0, std::span(&run, 1)),
                              options(StepsPerSegment{4}), swept);
    return report ? Error{ErrorCode::Failed, "none", {}} : report.error();
  };
  for (const double turn : {0.0, 90.0, 360.0}) {
    EXPECT_EQ(errorOfShift(1e11, turn).message, "none");
    EXPECT_EQ(errorOfShift(1e20, turn).remedy, Remedy::Motion);
    EXPECT_EQ(errorOfShift(1e65, turn).remedy, Remedy::Motion);
  }
}

TEST(Sweep, SolidsBeyondTheRangeOfMeasuresAreRefused) {
  for (const double size : {1e71, 1e-71}) {
    model::Mesh swept;
    const auto report = sweep(fixtures::cube(size), turnAbout(Eigen::Vector3d::UnitX(), 10),
                              options(StepsPerSegment{1}), swept);
    ASSERT_FALSE(report);
    EXPECT_NE(report.error().message.find("that can be swept is"), std::string::npos);
  }
}

TEST(Sweep, HypervolumeHoldsAtAnyOffset) {
  for (const double offset : {0.0, 1e6, 1.5e11, 1e12}) {
    SCOPED_TRACE(offset);
    model::TriangleMesh mesh = fixtures::cube(20);
    for (model::Point3& vertex : mesh.vertices) vertex += model::Point3::Constant(offset);
    model::Mesh swept;
    const auto report =
        sweep(mesh, turnAbout(Eigen::Vector3d(1, 2, 3).normalized(), 30), options(), swept);
    ASSERT_TRUE(report) << report.error().text();
    const auto judged = *measure::checkMesh(swept);
    EXPECT_TRUE(judged.valid());
    EXPECT_EQ(judged.degenerateCells, 0U);
    const double theta = 30.0 / static_cast<double>(report->steps) * M_PI / 180;
    const double expected = 8000 * (2 + std::cos(theta)) / 3;
    // Corners are rounded to a few units in the last place of the offset.
    EXPECT_NEAR(judged.hypervolume / expected, 1, 1e-12 + 1e-16 * offset);
  }
}

}  // namespace
}  // namespace t4d::mesh4d
