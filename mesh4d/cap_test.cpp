#include "mesh4d/cap.h"

#include <gtest/gtest.h>

#include "fixtures/solids.h"

namespace t4d::mesh4d {
namespace {

TEST(Cap, ConesHaveTheVolumeOfEverySolid) {
  for (const fixtures::NamedSolid& solid : fixtures::allSolids({})) {
    SCOPED_TRACE(solid.name);
    const auto cap = fillSolid(solid.mesh, CapMethod::Cone);
    ASSERT_TRUE(cap) << cap.error().text();
    ASSERT_EQ(cap->inner.size(), 1U);
    EXPECT_EQ(cap->cells.size(), solid.mesh.triangles.size());
    std::vector<model::Point3> points = solid.mesh.vertices;
    points.push_back(cap->inner.front());
    double volume = 0;
    for (const auto& [a, b, c, d] : cap->cells) {
      volume +=
          (points[b] - points[a]).dot((points[c] - points[a]).cross(points[d] - points[a])) / 6;
    }
    const double expected = signedVolume(solid.mesh);
    EXPECT_NEAR(volume, expected, 1e-9 * expected);
  }
}

}  // namespace
}  // namespace t4d::mesh4d
