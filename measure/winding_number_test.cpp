#include "measure/winding_number.h"

#include <random>

#include <gtest/gtest.h>

#include "fixtures/solids.h"

namespace t4d::measure {
namespace {

using model::Point3;

TEST(WindingNumber, IsOneInsideZeroOutsideAndAHalfOnTheSurface) {
  const WindingNumber winding(fixtures::cube(2));
  EXPECT_NEAR(winding.exactAt({0.3, -0.2, 0.9}), 1, 1e-12);
  EXPECT_NEAR(winding.exactAt({0.3, -0.2, 1.1}), 0, 1e-12);
  EXPECT_NEAR(winding.exactAt({0.3, -0.2, 1}), 0.5, 1e-12);  // exactly in the plane
}

TEST(WindingNumber, CountsOverlapsAndCavities) {
  auto mesh = fixtures::hollowCube(4, 2);
  const auto cube = fixtures::translated(fixtures::cube(2), {2, 0, 0});
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), cube.vertices.begin(), cube.vertices.end());
  for (const auto& [a, b, c] : cube.triangles) {
    mesh.triangles.push_back({a + first, b + first, c + first});
  }
  const WindingNumber winding(mesh);
  EXPECT_NEAR(winding.exactAt({0.1, 0.2, 0}), 0, 1e-12);
  EXPECT_NEAR(winding.exactAt({-1.5, 0.2, 0.1}), 1, 1e-12);
  EXPECT_NEAR(winding.exactAt({1.5, 0.2, 0.1}), 2, 1e-12);
}

TEST(WindingNumber, OfADiscFallsSmoothlyAcrossItsRim) {
  // Half of a cube's surface, seen from the middle of the missing half.
  auto mesh = fixtures::cube(2);
  std::erase_if(mesh.triangles, [&](const model::Triangle& triangle) {
    return mesh.vertices[triangle[0]].z() < 0 && mesh.vertices[triangle[1]].z() < 0 &&
           mesh.vertices[triangle[2]].z() < 0;
  });
  ASSERT_EQ(mesh.triangles.size(), 10U);
  EXPECT_NEAR(WindingNumber(mesh).exactAt({0, 0, 0}), 5.0 / 6, 1e-12);
}

TEST(WindingNumber, OfTheTreeIsNearTheSum) {
  const WindingNumber winding(fixtures::torus(3, 1, 96, 48));
  std::mt19937 random(1);
  std::uniform_real_distribution<double> coordinate(-4, 4);
  double worst = 0;
  for (int i = 0; i < 2000; ++i) {
    const Point3 point(coordinate(random), coordinate(random), coordinate(random) / 3);
    worst = std::max(worst, std::abs(winding.at(point) - winding.exactAt(point)));
  }
  EXPECT_LT(worst, 0.05);
}

}  // namespace
}  // namespace t4d::measure
