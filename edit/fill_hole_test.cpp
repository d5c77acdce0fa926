#include "edit/fill_hole.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>
#include <span>
#include <vector>

#include <gtest/gtest.h>

namespace t4d::edit {
namespace {

using model::Point3;

double areaOf(const Point3& a, const Point3& b, const Point3& c) {
  return (b - a).cross(c - a).norm() / 2;
}

/// The least area of all ways to fill the part of a loop between two of its corners.
double leastArea(std::span<const Point3> part) {
  if (part.size() < 3) return 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i + 1 < part.size(); ++i) {
    least = std::min(least, areaOf(part.front(), part[i], part.back()) +
                                leastArea(part.first(i + 1)) + leastArea(part.subspan(i)));
  }
  return least;
}

TEST(FillHole, TakesTheLeastAreaWhereDelaunayHasNoWay) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int trial = 0; trial < 100; ++trial) {
    model::TriangleMesh mesh;
    for (int i = 0; i < 5 + trial % 4; ++i) {
      mesh.vertices.emplace_back(number(random), number(random), number(random));
    }
    // A side without length is in no Delaunay triangulation.
    const std::size_t side = random() % mesh.vertices.size();
    mesh.vertices[side] = mesh.vertices[(side + 1) % mesh.vertices.size()];
    std::vector<std::uint32_t> loop(mesh.vertices.size());
    std::iota(loop.begin(), loop.end(), 0U);
    const auto filled = fillHole(mesh, loop, std::vector<std::uint32_t>(loop.size(), 0));
    ASSERT_TRUE(filled) << filled.error().text();
    EXPECT_EQ(filled->size() + 2, loop.size());
    double area = 0;
    for (const auto& [a, b, c] : *filled) {
      area += areaOf(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]);
    }
    EXPECT_NEAR(area, leastArea(mesh.vertices), 1e-12 * area);
  }
}

}  // namespace
}  // namespace t4d::edit
