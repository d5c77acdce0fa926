#include "t4d/mesh4d/sweep.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "t4d/fixtures/solids.h"
#include "t4d/measure/mesh_check.h"

namespace t4d::mesh4d {
namespace {

model::Motion turnAbout(const Eigen::Vector3d& axis, double degrees, double duration = 1) {
  model::ScrewRun run;
  run.duration = duration;
  run.screw.axisDirection = axis;
  run.screw.angleDegrees = degrees;
  return *model::chainScrews(0, std::span(&run, 1));
}

Error errorOf(const model::TriangleMesh& mesh, const SweepOptions& options = {}) {
  model::Mesh into;
  const auto report = sweep(mesh, turnAbout(Eigen::Vector3d::UnitX(), 30), options, into);
  EXPECT_FALSE(report);
  return report ? Error() : report.error();
}

std::string refusalOf(const model::TriangleMesh& mesh, const SweepOptions& options = {}) {
  return errorOf(mesh, options).text();
}

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

TEST(Cap, FillsEverySolidWithItsVolume) {
  for (const fixtures::NamedSolid& solid : fixtures::allSolids({})) {
    for (const CapMethod method : {CapMethod::TetGen, CapMethod::Cone}) {
      const auto cap = fillSolid(solid.mesh, method);
      ASSERT_TRUE(cap) << solid.name << ": " << cap.error().text();
      std::vector<model::Point3> points = solid.mesh.vertices;
      points.insert(points.end(), cap->inner.begin(), cap->inner.end());
      double volume = 0;
      for (const auto& [a, b, c, d] : cap->cells) {
        const double six =
            (points[b] - points[a]).dot((points[c] - points[a]).cross(points[d] - points[a]));
        EXPECT_TRUE(method == CapMethod::Cone || six > 0) << solid.name;
        volume += six / 6;
      }
      const double expected = signedVolume(solid.mesh);
      EXPECT_NEAR(volume, expected, 1e-9 * expected) << solid.name;
    }
  }
}

TEST(Cap, CavityStaysEmpty) {
  const auto cap = fillSolid(fixtures::hollowCube(4, 2), CapMethod::TetGen);
  ASSERT_TRUE(cap) << cap.error().text();
  // Every facet that only one cell has is a triangle of one of the two shells.
  model::Connectivity cells;
  cells.vertexCount = 16 + static_cast<std::uint32_t>(cap->inner.size());
  cells.cells = cap->cells;
  EXPECT_EQ(facetTopology(cells).unmatched.size(), 24U);
}

TEST(Sweep, InsideOutMeshIsTurnedRoundWithANotice) {
  model::TriangleMesh mesh = fixtures::cube(2);
  for (model::Triangle& triangle : mesh.triangles) std::swap(triangle[0], triangle[1]);
  model::Mesh swept;
  const auto report = sweep(mesh, turnAbout(Eigen::Vector3d::UnitX(), 10), {}, swept);
  ASSERT_TRUE(report) << report.error().text();
  ASSERT_EQ(report->notices.size(), 1U);
  EXPECT_NE(report->notices[0].find("inside out"), std::string::npos);
  EXPECT_GT(measure::checkMesh(swept)->hypervolume, 0);
}

TEST(Sweep, StepsOfMoreThanAQuarterTurnAreReported) {
  const auto noticesOf = [](double degrees, std::uint64_t steps) {
    model::Mesh swept;
    SweepOptions options;
    options.steps = StepsPerSegment{steps};
    return sweep(fixtures::cube(2), turnAbout(Eigen::Vector3d::UnitX(), degrees), options, swept)
        ->notices;
  };
  EXPECT_TRUE(noticesOf(360, 4).empty());
  for (const auto& notices : {noticesOf(-360, 3), noticesOf(360, 1)}) {
    ASSERT_EQ(notices.size(), 1U);
    EXPECT_NE(notices[0].find("a step of segment 0 turns by"), std::string::npos);
  }
}

TEST(Sweep, ConesAreReported) {
  model::Mesh swept;
  SweepOptions options;
  options.caps = CapMethod::Cone;
  const auto report =
      sweep(fixtures::torus(2, 1, 8, 6), turnAbout(Eigen::Vector3d::UnitX(), 10), options, swept);
  ASSERT_EQ(report->notices.size(), 1U);
  EXPECT_NE(report->notices[0].find("cones"), std::string::npos);
  // The apex over a torus is no manifold point: a warning of the deep check.
  const auto judged = *measure::checkMesh(swept, {.vertexLinks = true});
  EXPECT_TRUE(judged.closed && judged.oriented && judged.valid());
  EXPECT_FALSE(*judged.vertexLinksOk);
  EXPECT_EQ(judged.issues.issues.front().code, "cap-vertex-link");
  EXPECT_EQ(judged.degenerateCells, 0U);
}

TEST(Sweep, OneComponentForEachOfTheInputs) {
  model::Mesh swept;
  ASSERT_TRUE(sweep(fixtures::twoBoxes(2, 1), turnAbout(Eigen::Vector3d::UnitX(), 10), {}, swept));
  EXPECT_EQ(measure::checkMesh(swept)->components, 2U);
}

TEST(Sweep, SelfIntersectionNamesTrianglesAndTheWayOut) {
  model::TriangleMesh mesh = fixtures::cube(2);
  const model::TriangleMesh other = fixtures::cube(2);
  for (const model::Point3& vertex : other.vertices) {
    mesh.vertices.push_back(vertex + model::Point3(0.5, 0.6, 0.7));
  }
  for (const auto& [a, b, c] : other.triangles) mesh.triangles.push_back({a + 8, b + 8, c + 8});
  const Error refusal = errorOf(mesh);
  EXPECT_NE(refusal.text().find("pairs of triangles"), std::string::npos) << refusal.text();
  EXPECT_EQ(refusal.remedy, Remedy::ConeCaps);
  SweepOptions cone;
  cone.caps = CapMethod::Cone;
  model::Mesh swept;
  ASSERT_TRUE(sweep(mesh, turnAbout(Eigen::Vector3d::UnitX(), 10), cone, swept));
  EXPECT_TRUE(measure::checkMesh(swept)->valid());
}

TEST(Sweep, TriangleWithoutAreaIsNamed) {
  // A box whose top edge is split on one side only, by a triangle of no area on the other.
  model::TriangleMesh mesh = fixtures::cube(2);
  const auto [a, b, c] = mesh.triangles[0];
  const auto middle = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.push_back(0.5 * (mesh.vertices[a] + mesh.vertices[b]));
  mesh.triangles[0] = {a, middle, c};
  mesh.triangles.push_back({middle, b, c});
  mesh.triangles.push_back({a, b, middle});
  EXPECT_NE(refusalOf(mesh).find("1 triangles have no area (counted from 0: 13)"),
            std::string::npos);
}

TEST(Sweep, InsideOutComponentIsRefused) {
  model::TriangleMesh mesh = fixtures::twoBoxes(2, 1);
  for (std::size_t i = 0; i < 12; ++i) std::swap(mesh.triangles[i][0], mesh.triangles[i][1]);
  // The larger box decides which way the whole faces.
  for (model::Point3& vertex : mesh.vertices) {
    if (vertex.x() > 0) vertex *= 2;
  }
  EXPECT_NE(refusalOf(mesh).find("turn it round"), std::string::npos);
}

TEST(Sweep, SolidInACavityIsFilled) {
  model::TriangleMesh mesh = fixtures::hollowCube(8, 4);
  const model::TriangleMesh core = fixtures::cube(2);
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), core.vertices.begin(), core.vertices.end());
  for (const auto& [a, b, c] : core.triangles) {
    mesh.triangles.push_back({a + first, b + first, c + first});
  }
  model::Mesh swept;
  const auto report = sweep(mesh, turnAbout(Eigen::Vector3d::UnitX(), 20), {}, swept);
  ASSERT_TRUE(report) << report.error().text();
  const auto judged = *measure::checkMesh(swept, {.vertexLinks = true});
  EXPECT_TRUE(judged.valid() && *judged.vertexLinksOk);
  const double volume = 512 - 64 + 8;
  double expected = 0;
  const double theta = 20.0 / static_cast<double>(report->steps) * M_PI / 180;
  expected = volume * (2 + std::cos(theta)) / 3;
  EXPECT_NEAR(judged.hypervolume, expected, 1e-9 * expected);
  // The shells of a cavity are joined through the solid, the core stands alone.
  EXPECT_EQ(judged.components, 2U);
}

TEST(Sweep, SinkThatFailsEndsTheSweep) {
  class Full : public model::Sink {
   public:
    Result<void> put(const model::Slab&) override {
      return fail(ErrorCode::Io, "No space left on device", "disk");
    }
  } full;
  const auto report = sweep(fixtures::cube(1), turnAbout(Eigen::Vector3d::UnitX(), 10), {}, full);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().where, "disk");
}

TEST(Sweep, DurationTooShortForItsStepsIsRefused) {
  model::ScrewRun run;
  run.duration = 4e-16;
  run.screw.translation = {1, 0, 0};
  const model::Motion motion = *model::chainScrews(1, std::span(&run, 1));
  SweepOptions options;
  options.steps = StepsPerSegment{100};
  model::Mesh swept;
  const auto report = sweep(fixtures::cube(1), motion, options, swept);
  ASSERT_FALSE(report);
  EXPECT_NE(report.error().message.find("too short for 100 steps"), std::string::npos);
}

}  // namespace
}  // namespace t4d::mesh4d
