#include "t4d/mesh4d/sweep.h"

#include <gtest/gtest.h>

#include "t4d/fixtures/solids.h"
#include "t4d/measure/mesh_check.h"
#include "t4d/mesh4d/test_motion.h"

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
  EXPECT_EQ(report.error().where, "disk");
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
  EXPECT_NE(report.error().message.find("too short for 100 steps"), std::string::npos);
}

}  // namespace
}  // namespace t4d::mesh4d
