#include "measure/distance_quantile.h"

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "t4d/check.h"

namespace t4d::measure {
namespace {

using model::TriangleMesh;

/// The square from (0, 0) to (1, 1), its height in z growing with x; a fan about a point near one
/// corner, so that its triangles differ a lot in size.
TriangleMesh ramp(double height) {
  TriangleMesh mesh;
  for (const auto& [x, y] : {std::pair{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}, {0.1, 0.2}}) {
    mesh.vertices.emplace_back(x, y, height * x);
  }
  mesh.triangles = {{4, 0, 1}, {4, 1, 2}, {4, 2, 3}, {4, 3, 0}};
  return mesh;
}

TEST(DistanceQuantile, OfARampIsItsHeightThere) {
  TriangleMesh floor = ramp(0);
  for (model::Point3& vertex : floor.vertices) vertex *= 3;
  for (const double fraction : {0.0, 0.25, 0.5, 0.9, 0.99, 1.0}) {
    EXPECT_NEAR(distanceQuantile(ramp(0.2), floor, fraction), 0.2 * fraction, 0.2 * 0.01);
  }
}

TEST(DistanceQuantile, OneOutlierDoesNotMatter) {
  TriangleMesh spiked = fixtures::icosphere(10, 4);
  for (model::Point3& vertex : spiked.vertices) vertex *= 1.01;
  spiked.vertices[100] *= 2;
  const TriangleMesh sphere = fixtures::icosphere(10, 4);
  EXPECT_GT(surfaceDistance(spiked, sphere).fromA, 9);
  EXPECT_NEAR(distanceQuantile(spiked, sphere, 0.9), 0.1, 0.01);
}

TEST(DistanceQuantile, IsZeroForTheSameSurfaceAndForNone) {
  const TriangleMesh sphere = fixtures::icosphere(10, 2);
  EXPECT_NEAR(distanceQuantile(sphere, sphere, 1), 0, 1e-12);
  EXPECT_EQ(distanceQuantile({}, sphere, 0.99), 0);
  EXPECT_EQ(distanceQuantile(sphere, {}, 0.99), 0);
}

}  // namespace
}  // namespace t4d::measure
