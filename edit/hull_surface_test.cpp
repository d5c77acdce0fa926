#include <random>

#include <gtest/gtest.h>

#include "edit/convex_hull.h"
#include "fixtures/solids.h"
#include "model/surface_check.h"
#include "t4d/edit.h"

namespace t4d::edit {
namespace {

using model::Point3;
using model::TriangleMesh;

/// How far the farthest point is outside of a face; each face must have an area.
double farthestOutside(const TriangleMesh& hull, const std::vector<Point3>& points) {
  double farthest = 0;
  for (const auto& [a, b, c] : hull.triangles) {
    const Point3& p = hull.vertices[a];
    const Point3 normal = (hull.vertices[b] - p).cross(hull.vertices[c] - p);
    EXPECT_GT(normal.norm(), 0);
    for (const Point3& q : points) farthest = std::max(farthest, normal.normalized().dot(q - p));
  }
  return farthest;
}

TEST(ConvexHull, HasAllPointsAndNoMore) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 20; ++i) {
    std::vector<Point3> points;
    for (int k = 0; k < 200; ++k)
      points.emplace_back(normal(random), normal(random), normal(random));
    const auto hull = convexHull(points);
    ASSERT_TRUE(hull);
    EXPECT_TRUE(model::checkClosedSurface(*hull));
    EXPECT_LT(farthestOutside(*hull, points), 1e-14);
    EXPECT_GT(signedVolume(*hull), 0);
    // A triangulated sphere.
    EXPECT_EQ(hull->triangles.size(), 2 * hull->vertices.size() - 4);
    for (const Point3& vertex : hull->vertices) {
      EXPECT_NE(std::ranges::find(points, vertex), points.end());
    }
  }
}

TEST(ConvexHull, IsSoundWherePointsAreInLinesAndPlanes) {
  std::vector<Point3> lattice;
  for (int x = 0; x < 4; ++x) {
    for (int y = 0; y < 4; ++y) {
      for (int z = 0; z < 4; ++z) lattice.emplace_back(0.1 * x, 0.1 * y, 0.1 * z);
    }
  }
  const auto hull = convexHull(lattice);
  ASSERT_TRUE(hull);
  EXPECT_TRUE(model::checkClosedSurface(*hull));
  EXPECT_EQ(farthestOutside(*hull, lattice), 0);
  EXPECT_NEAR(signedVolume(*hull), 0.027, 1e-15);
}

TEST(HullSurface, ClosesWhatIsOpenAndReportsBothVolumes) {
  TriangleMesh open = fixtures::cube(2);
  open.triangles.pop_back();
  const auto closed = hullSurface(open);
  ASSERT_TRUE(closed) << closed.error().text();
  EXPECT_FALSE(closed->volumeBefore);
  EXPECT_NEAR(closed->volumeAfter, 8, 1e-14);
  EXPECT_EQ(signedVolume(open), closed->volumeAfter);
  EXPECT_TRUE(model::checkClosedSurface(open));
  ASSERT_EQ(closed->changes.size(), 1U);
  EXPECT_EQ(closed->changes[0].kind, SurfaceFault::Hull);

  // Two cubes at a distance of 2 along x: the hull is a box of 6 x 2 x 2.
  TriangleMesh two = fixtures::cube(2);
  for (const auto& [a, b, c] : fixtures::cube(2).triangles) {
    two.triangles.push_back({a + 8, b + 8, c + 8});
  }
  for (int i = 0; i < 8; ++i) two.vertices.emplace_back(two.vertices[i] + Point3(4, 0, 0));
  two.vertices.emplace_back(0, 0, 100);  // no triangle has it
  const auto one = hullSurface(two);
  ASSERT_TRUE(one);
  EXPECT_NEAR(*one->volumeBefore, 16, 1e-14);
  EXPECT_NEAR(one->volumeAfter, 24, 1e-14);
  EXPECT_NEAR(one->hausdorff, 1, 6e-3);  // the middle of the gap, from the cubes
  EXPECT_EQ(one->lost.triangles, 0U);
}

TEST(HullSurface, RefusesWhatIsFlatAndKeepsIt) {
  TriangleMesh flat{{{0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}}, {{0, 1, 2}, {2, 1, 3}}, {}};
  const auto hull = hullSurface(flat);
  ASSERT_FALSE(hull);
  EXPECT_EQ(flat.triangles.size(), 2U);
  EXPECT_NE(hull.error().message.find("in a plane"), std::string::npos);
}

}  // namespace
}  // namespace t4d::edit
