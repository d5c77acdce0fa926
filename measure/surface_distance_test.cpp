#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "measure/triangle_tree.h"
#include "t4d/check.h"

namespace t4d::measure {
namespace {

using model::Point3;
using model::TriangleMesh;

/// Checks that the known value lies in the interval of the result.
void expectWithin(double value, double found, double tolerance) {
  EXPECT_LE(found, value * (1 + 1e-12) + 1e-12);
  EXPECT_GE(found + tolerance, value * (1 - 1e-12) - 1e-12);
}

TEST(TriangleTree, IsAsNearAsTheNearestOfAllTriangles) {
  const TriangleMesh torus = fixtures::torus(3, 1, 24, 12);
  const TriangleTree tree(torus);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(-6, 6);
  for (int i = 0; i < 300; ++i) {
    const Point3 point(number(random), number(random), number(random));
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t t = 0; t < torus.triangles.size(); ++t) {
      least = std::min(least, tree.distanceTo(t, point));
    }
    const TriangleTree::Nearest nearest = tree.nearest(point);
    EXPECT_EQ(nearest.distance, least);
    EXPECT_EQ(tree.distanceTo(nearest.triangle, point), least);
  }
}

TEST(TriangleTree, DistanceToATriangleIsThatOfItsNearestPoint) {
  // Compared with many points of the triangle, and of one without area.
  std::mt19937 random(2);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int i = 0; i < 60; ++i) {
    TriangleMesh mesh;
    for (int j = 0; j < 3; ++j) {
      mesh.vertices.emplace_back(number(random), number(random), number(random));
    }
    if (i % 3 == 0) mesh.vertices[2] = 0.3 * mesh.vertices[0] + 0.7 * mesh.vertices[1];
    mesh.triangles = {{0, 1, 2}};
    const TriangleTree tree(mesh);
    const Point3 point(2 * number(random), 2 * number(random), 2 * number(random));
    double least = std::numeric_limits<double>::infinity();
    constexpr int kParts = 200;
    for (int u = 0; u <= kParts; ++u) {
      for (int v = 0; u + v <= kParts; ++v) {
        const Point3 there = mesh.vertices[0] +
                             (mesh.vertices[1] - mesh.vertices[0]) * (u / double{kParts}) +
                             (mesh.vertices[2] - mesh.vertices[0]) * (v / double{kParts});
        least = std::min(least, (there - point).norm());
      }
    }
    EXPECT_LE(tree.nearest(point).distance, least + 1e-12);
    EXPECT_GE(tree.nearest(point).distance, least - 0.02);
  }
}

TEST(SurfaceDistance, OfASurfaceFromItselfIsZero) {
  for (const fixtures::NamedSolid& solid : fixtures::allSolids()) {
    const SurfaceDistance distance = surfaceDistance(solid.mesh, solid.mesh);
    EXPECT_EQ(distance.hausdorff(), 0) << solid.name;
  }
}

TEST(SurfaceDistance, OfAMovedCubeIsHowFarItMoved) {
  const TriangleMesh cube = fixtures::cube(2);
  for (const Eigen::Vector3d& by :
       {Eigen::Vector3d(0.25, 0, 0), Eigen::Vector3d(0.1, -0.2, 0.3), Eigen::Vector3d(0, 5, -7)}) {
    const SurfaceDistance distance = surfaceDistance(cube, fixtures::translated(cube, by));
    expectWithin(by.norm(), distance.fromA, distance.tolerance);
    expectWithin(by.norm(), distance.fromB, distance.tolerance);
  }
}

TEST(SurfaceDistance, OfScaledSpheresIsTheDifferenceOfRadii) {
  // The vertices of the outer one are farthest.
  const SurfaceDistance distance =
      surfaceDistance(fixtures::icosphere(1, 3), fixtures::icosphere(1.5, 3), 1e-4);
  expectWithin(0.5, distance.hausdorff(), distance.tolerance);
}

TEST(SurfaceDistance, IsFoundWhereNoVertexIs) {
  // A flat square against a roof over it whose ridge runs between two of its sides' midpoints: the
  // roof is farthest at the ridge's ends, the square under the ridge.
  TriangleMesh square;
  square.vertices = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  square.triangles = {{0, 1, 2}, {0, 2, 3}};
  TriangleMesh roof;
  roof.vertices = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {-1, 0, 1}, {1, 0, 1}};
  roof.triangles = {{0, 1, 5}, {0, 5, 4}, {3, 4, 5}, {3, 5, 2}};
  const SurfaceDistance distance = surfaceDistance(square, roof, 1e-6);
  expectWithin(std::sqrt(0.5), distance.fromA, distance.tolerance);
  expectWithin(1, distance.fromB, distance.tolerance);
}

TEST(SurfaceDistance, TwoSidedValueIsSymmetric) {
  const TriangleMesh torus = fixtures::torus(3, 1, 24, 12);
  const TriangleMesh cube = fixtures::cube(4);
  const SurfaceDistance one = surfaceDistance(torus, cube);
  const SurfaceDistance other = surfaceDistance(cube, torus);
  EXPECT_EQ(one.fromA, other.fromB);
  EXPECT_EQ(one.fromB, other.fromA);
}

TEST(SurfaceDistance, ASmallerToleranceOnlyRaisesIt) {
  const TriangleMesh torus = fixtures::torus(3, 1, 12, 8);
  const TriangleMesh fine = fixtures::torus(3, 1, 48, 32);
  double before = 0;
  for (const double tolerance : {1e-1, 1e-2, 1e-3, 1e-4}) {
    const SurfaceDistance distance = surfaceDistance(torus, fine, tolerance);
    EXPECT_GE(distance.hausdorff(), before);
    before = distance.hausdorff();
  }
}

TEST(FartherThan, DecidesAroundTheTrueDistance) {
  const TriangleMesh torus = fixtures::torus(3, 1, 24, 12);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-0.3, 0.3);
  for (int i = 0; i < 12; ++i) {
    TriangleMesh other = torus;
    for (Point3& vertex : other.vertices) {
      vertex += Point3(number(random), number(random), number(random));
    }
    const SurfaceDistance found = surfaceDistance(torus, other, 1e-4);
    const double most = found.hausdorff() + found.tolerance;
    const auto none = fartherThan(1.001 * most, torus, other);
    ASSERT_TRUE(none);
    EXPECT_FALSE(*none) << **none;
    const auto some = fartherThan(0.99 * found.hausdorff(), torus, other);
    ASSERT_TRUE(some && *some);
    EXPECT_GT(**some, 0.99 * found.hausdorff());
    EXPECT_LE(**some, most);
  }
  EXPECT_TRUE(std::isinf(**fartherThan(1, torus, {})));
  EXPECT_FALSE(*fartherThan(1, {}, {}));
  EXPECT_FALSE(*fartherThan(0, torus, torus));
}

TEST(FartherThan, FindsThatOtherTrianglesOfACubeAreTheSameSurface) {
  TriangleMesh cube = fixtures::cube(2);
  TriangleMesh finer = fixtures::paperCube(3);
  const double scale = 2 / (model::boundsOf(finer).max - model::boundsOf(finer).min).x();
  const Point3 offset = model::boundsOf(cube).min - scale * model::boundsOf(finer).min;
  for (Point3& vertex : finer.vertices) vertex = scale * vertex + offset;
  const auto near = fartherThan(0.001, cube, finer);
  ASSERT_TRUE(near);
  EXPECT_FALSE(*near);
}

TEST(SurfaceDistance, FromNothingIsInfinite) {
  const TriangleMesh cube = fixtures::cube(1);
  EXPECT_EQ(surfaceDistance(cube, {}).hausdorff(), std::numeric_limits<double>::infinity());
  EXPECT_EQ(surfaceDistance({}, cube).hausdorff(), std::numeric_limits<double>::infinity());
  EXPECT_EQ(surfaceDistance({}, {}).hausdorff(), 0);
}

}  // namespace
}  // namespace t4d::measure
