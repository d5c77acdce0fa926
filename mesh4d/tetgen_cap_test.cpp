#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "mesh4d/cap.h"
#include "mesh4d/test_motion.h"
#include "model/facets.h"
#include "t4d/check.h"
#include "t4d/sweep.h"

namespace t4d::mesh4d {
namespace {

Error errorOf(const model::TriangleMesh& mesh) {
  model::Mesh into;
  const auto report = sweep(mesh, turnAbout(Eigen::Vector3d::UnitX(), 30), {}, into);
  EXPECT_FALSE(report);
  return report ? Error() : report.error();
}

TEST(TetGenCap, FillsEverySolidWithItsVolume) {
  for (const fixtures::NamedSolid& solid : fixtures::allSolids({})) {
    SCOPED_TRACE(solid.name);
    const auto cap = fillSolid(solid.mesh, CapMethod::TetGen);
    ASSERT_TRUE(cap) << cap.error().text();
    std::vector<model::Point3> points = solid.mesh.vertices;
    points.insert(points.end(), cap->inner.begin(), cap->inner.end());
    double volume = 0;
    for (const auto& [a, b, c, d] : cap->cells) {
      const double six =
          (points[b] - points[a]).dot((points[c] - points[a]).cross(points[d] - points[a]));
      EXPECT_GT(six, 0);
      volume += six / 6;
    }
    const double expected = signedVolume(solid.mesh);
    EXPECT_NEAR(volume, expected, 1e-9 * expected);
  }
}

/// The mesh with every vertex times `scale` plus `offset`.
model::TriangleMesh placedAt(model::TriangleMesh mesh, double scale, double offset) {
  for (model::Point3& vertex : mesh.vertices) {
    vertex = scale * vertex + model::Point3::Constant(offset);
  }
  return mesh;
}

TEST(TetGenCap, FillsSolidsOfAnySizeAndPlace) {
  for (const fixtures::NamedSolid& solid : fixtures::allSolids({})) {
    for (const auto& [scale, offset] : {std::pair{1e60, 0.0}, {1e-62, 0.0}, {1e-53, 1e-52}}) {
      SCOPED_TRACE(fmt::format("{} times {} plus {}", solid.name, scale, offset));
      const model::TriangleMesh mesh = placedAt(solid.mesh, scale, offset);
      const auto cap = fillSolid(mesh, CapMethod::TetGen);
      ASSERT_TRUE(cap) << cap.error().text();
      std::vector<model::Point3> points = mesh.vertices;
      points.insert(points.end(), cap->inner.begin(), cap->inner.end());
      double volume = 0;
      for (const auto& [a, b, c, d] : cap->cells) {
        volume +=
            (points[b] - points[a]).dot((points[c] - points[a]).cross(points[d] - points[a])) / 6;
      }
      EXPECT_NEAR(volume / signedVolume(mesh), 1, 1e-9);
    }
  }
}

TEST(TetGenCap, FillsAPowerOfTwoTimesASolidAlike) {
  const model::TriangleMesh torus = fixtures::torus(2, 1, 24, 12);
  const auto cap = fillSolid(torus, CapMethod::TetGen);
  const auto large = fillSolid(placedAt(torus, std::ldexp(1.0, 200), 0), CapMethod::TetGen);
  ASSERT_TRUE(cap && large);
  EXPECT_EQ(large->cells, cap->cells);
  ASSERT_EQ(large->inner.size(), cap->inner.size());
  for (std::size_t i = 0; i < cap->inner.size(); ++i) {
    EXPECT_EQ(large->inner[i], cap->inner[i] * std::ldexp(1.0, 200));
  }
}

TEST(TetGenCap, LargeSolidsHaveTheMemoryThatTheyNeed) {
  const auto cap = fillSolid(fixtures::torus(10, 3, 250, 100), CapMethod::TetGen);
  EXPECT_TRUE(cap) << cap.error().text();
}

TEST(TetGenCap, FansOfManyTrianglesAreRefusedAtOnce) {
  EXPECT_NE(errorOf(fixtures::bipyramid(20'000)).message.find("has 20000 triangles"),
            std::string::npos);
}

TEST(TetGenCap, CavityStaysEmpty) {
  const auto cap = fillSolid(fixtures::hollowCube(4, 2), CapMethod::TetGen);
  ASSERT_TRUE(cap) << cap.error().text();
  // Every facet of a single cell is a triangle of one of the two shells.
  model::Connectivity cells;
  cells.vertexCount = 16 + static_cast<std::uint32_t>(cap->inner.size());
  cells.cells = cap->cells;
  EXPECT_EQ(facetTopology(cells).unmatched.size(), 24U);
}

TEST(TetGenCap, InsideOutComponentIsRefused) {
  model::TriangleMesh mesh = fixtures::twoBoxes(2, 1);
  for (std::size_t i = 0; i < 12; ++i) std::swap(mesh.triangles[i][0], mesh.triangles[i][1]);
  // The larger box decides the orientation of the whole mesh.
  for (model::Point3& vertex : mesh.vertices) {
    if (vertex.x() > 0) vertex *= 2;
  }
  EXPECT_EQ(errorOf(mesh).message,
            "triangle 0 faces into the solid: its component is inside out; turn it round");
}

TEST(TetGenCap, SolidInACavityIsFilled) {
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
  // The shells of a cavity are connected through the solid; the core is separate.
  EXPECT_EQ(judged.components, 2U);
}

TEST(TetGenCap, OneComponentForEachOfTheInputs) {
  model::Mesh swept;
  ASSERT_TRUE(sweep(fixtures::twoBoxes(2, 1), turnAbout(Eigen::Vector3d::UnitX(), 10), {}, swept));
  EXPECT_EQ(measure::checkMesh(swept)->components, 2U);
}

TEST(TetGenCap, FillsTheEndsOfADeformationAsTheSolidIsThere) {
  // A bar bent to a hook: the cells that fill the bar would leave it.
  model::TriangleMesh bar = fixtures::icosphere(1, 3);
  for (model::Point3& p : bar.vertices) p.x() *= 4;
  std::vector<model::StoredKeys::Key> keys{{0, bar.vertices}, {1, bar.vertices}};
  for (model::Point3& p : keys[1].positions) {
    const double angle = 0.2 * p.x();
    p = {(5 - p.y()) * std::sin(angle), 5 - (5 - p.y()) * std::cos(angle), p.z()};
  }
  model::Mesh swept;
  const auto report = sweep(bar, model::StoredKeys(keys), {}, swept);
  ASSERT_TRUE(report) << report.error().text();
  const auto judged = *measure::checkMesh(swept, {.vertexLinks = true});
  EXPECT_TRUE(judged.closed && judged.oriented && judged.valid());
  EXPECT_TRUE(*judged.vertexLinksOk);
}

}  // namespace
}  // namespace t4d::mesh4d
