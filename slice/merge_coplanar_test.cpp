#include "slice/merge_coplanar.h"

#include <cstring>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "t4d/check.h"
#include "t4d/slice.h"
#include "t4d/sweep.h"

namespace t4d::slice {
namespace {

model::Mesh movedStraight(const model::TriangleMesh& solid, const model::Point3& by,
                          std::uint64_t steps, double angleDegrees = 0) {
  model::Screw screw;
  screw.translation = by;
  screw.angleDegrees = angleDegrees;
  const model::ScrewRun run{1, screw, 1};
  mesh4d::SweepOptions options;
  options.caps = mesh4d::CapMethod::Cone;
  options.steps = mesh4d::StepsPerSegment{steps};
  model::Mesh mesh;
  EXPECT_TRUE(mesh4d::sweep(solid, *model::chainScrews(0, {&run, 1}), options, mesh));
  return mesh;
}

/// Merges, and checks what must hold of every merge.
model::TriangleMesh merged(const model::TriangleMesh& before) {
  model::TriangleMesh after = before;
  const CoplanarMerge report = mergeCoplanar(after, false);
  EXPECT_EQ(report.trianglesBefore, before.triangles.size());
  EXPECT_LE(report.distance, report.tolerance);
  EXPECT_EQ(isClosed(after), isClosed(before));
  // Triangles with different values become one, which has none.
  for (const model::Attribute& attribute : after.attributes) {
    EXPECT_NE(attribute.domain, model::Domain::Cell) << attribute.name;
  }
  EXPECT_LE(after.triangles.size(), before.triangles.size());
  const double area = surfaceArea(before);
  EXPECT_NEAR(signedVolume(after), signedVolume(before), 4 * report.tolerance * area);
  EXPECT_NEAR(surfaceArea(after), area, 1e-12 * area);
  // Euler's number stays, so no hole is closed or torn.
  const auto euler = [](const model::TriangleMesh& mesh) {
    return static_cast<double>(mesh.vertices.size()) - mesh.triangles.size() / 2.0;
  };
  EXPECT_EQ(euler(after), euler(before));
  return after;
}

TEST(MergeCoplanar, TheSectionOfACubeThatMovesStraightIsABox) {
  // (y, z, t) of a cube of side 2 that moves along y: an oblique prism over a square, 12 triangles.
  for (const std::uint64_t steps : {1, 2, 7, 64}) {
    const model::Mesh mesh = movedStraight(fixtures::cube(2), {0, 5, 0}, steps);
    for (const double x : {0.3, -0.7}) {
      const auto section = slice(mesh, Hyperplane::across(0, x + 1));
      ASSERT_TRUE(section);
      if (section->mesh.triangles.empty()) continue;
      const model::TriangleMesh after = merged(section->mesh);
      EXPECT_EQ(after.triangles.size(), 12U) << steps << " steps, x = " << x;
      EXPECT_EQ(after.vertices.size(), 8U);
      EXPECT_NEAR(signedVolume(after), 4, 1e-12);
    }
  }
}

TEST(MergeCoplanar, KeepsTheSurfaceOfObliqueSections) {
  const model::TriangleMesh solids[] = {fixtures::cube(2), fixtures::hollowCube(4, 2),
                                        fixtures::torus(3, 1, 8, 4)};
  for (const model::TriangleMesh& solid : solids) {
    for (const double angle : {0.0, 70.0}) {
      const model::Mesh mesh = movedStraight(solid, {1, 2, 3}, 5, angle);
      for (const Hyperplane& plane :
           {Hyperplane{{1, 2, 0.5, 0.7}, 1.3}, Hyperplane::across(2, 0.77),
            Hyperplane{{0.2, -1, 3, -2}, 0.4}, Hyperplane::atTime(0.33)}) {
        const auto section = slice(mesh, plane);
        ASSERT_TRUE(section);
        if (section->mesh.triangles.empty()) continue;
        const model::TriangleMesh after = merged(section->mesh);
        if (angle == 0) {
          EXPECT_LT(after.triangles.size(), section->mesh.triangles.size() / 3);
        }
        EXPECT_LE(measure::surfaceDistance(after, section->mesh, 1e-2).hausdorff(), 1e-12);
      }
    }
  }
}

TEST(MergeCoplanar, KeepsBordersBetweenAttributes) {
  const model::Mesh mesh = movedStraight(fixtures::cube(2), {0, 5, 0}, 3);
  auto section = slice(mesh, Hyperplane::across(0, 0.6));
  ASSERT_TRUE(section);
  const double area = surfaceArea(section->mesh);
  model::TriangleMesh kept = section->mesh;
  mergeCoplanar(kept, true);
  EXPECT_GT(kept.triangles.size(), 12U);
  EXPECT_LT(kept.triangles.size(), section->mesh.triangles.size());
  EXPECT_NEAR(surfaceArea(kept), area, 1e-12 * area);
  ASSERT_EQ(kept.attributes.size(), section->mesh.attributes.size());
  // The area of each input triangle's part is the same.
  const auto areas = [](const model::TriangleMesh& of) {
    std::vector<double> sums(12, 0.0);
    for (std::size_t i = 0; i < of.triangles.size(); ++i) {
      std::uint32_t number = 0;
      for (const model::Attribute& attribute : of.attributes) {
        if (attribute.name == "triangle") std::memcpy(&number, attribute.row(i), 4);
      }
      const auto& [a, b, c] = of.triangles[i];
      const auto& v = of.vertices;
      if (number < 12) sums[number] += (v[b] - v[a]).cross(v[c] - v[a]).norm() / 2;
    }
    return sums;
  };
  const auto before = areas(section->mesh);
  const auto after = areas(kept);
  for (std::size_t i = 0; i < 12; ++i) EXPECT_NEAR(after[i], before[i], 1e-12);
  section->mesh.triangles.clear();
  section->mesh.vertices.clear();
  section->mesh.attributes.clear();
  EXPECT_EQ(mergeCoplanar(section->mesh, true).trianglesBefore, 0U);
}

}  // namespace
}  // namespace t4d::slice
