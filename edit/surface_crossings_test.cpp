#include "edit/surface_crossings.h"

#include <array>
#include <cstdint>
#include <set>
#include <utility>

#include <gtest/gtest.h>

#include "edit/outer_surface.h"
#include "fixtures/solids.h"

namespace t4d::edit {
namespace {

using model::Point3;
using model::TriangleMesh;

/// `rows` x `columns` copies of a mesh, `apart` from each other along two axes.
TriangleMesh copies(const TriangleMesh& mesh, int rows, int columns, const Point3& down,
                    const Point3& along) {
  TriangleMesh all;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const auto first = static_cast<std::uint32_t>(all.vertices.size());
      for (const Point3& p : mesh.vertices) all.vertices.push_back(p + row * down + column * along);
      for (const auto& [a, b, c] : mesh.triangles) {
        all.triangles.push_back({a + first, b + first, c + first});
      }
    }
  }
  return all;
}

/// A cube, and another one through its corner.
TriangleMesh crossingCubes() {
  TriangleMesh cubes = fixtures::cube(1);
  TriangleMesh other = fixtures::translated(cubes, {0.7, 0.6, 0.55});
  for (Point3& p : other.vertices) cubes.vertices.push_back(p);
  const auto first = static_cast<std::uint32_t>(other.vertices.size());
  for (const auto& [a, b, c] : other.triangles) {
    cubes.triangles.push_back({a + first, b + first, c + first});
  }
  return cubes;
}

TEST(SurfaceCrossings, CopiesCrossWhereTheOriginalDoes) {
  const TriangleMesh one = crossingCubes();
  const auto own = findCrossings(one, 1000);
  ASSERT_TRUE(own);
  ASSERT_FALSE(own->pairs.empty());
  // All in one plane; in a row; and in a plane that no axis is perpendicular to.
  struct Layout {
    int rows, columns;
    Point3 down, along;
  };
  for (const Layout& layout :
       {Layout{60, 60, {0, 3, 0}, {0, 0, 3}}, Layout{1, 3600, Point3::Zero(), {3, 0, 0}},
        Layout{60, 60, {3, 3, 0}, {0, -3, 3}}}) {
    const TriangleMesh mesh = copies(one, layout.rows, layout.columns, layout.down, layout.along);
    const auto found = findCrossings(mesh, 10'000'000);
    ASSERT_TRUE(found);
    EXPECT_TRUE(found->complete);
    std::set<std::pair<std::uint32_t, std::uint32_t>> expected;
    const auto triangles = static_cast<std::uint32_t>(one.triangles.size());
    for (int copy = 0; copy < layout.rows * layout.columns; ++copy) {
      const std::uint32_t first = static_cast<std::uint32_t>(copy) * triangles;
      for (const auto& [a, b] : own->pairs) expected.insert({first + a, first + b});
    }
    EXPECT_EQ(std::set(found->pairs.begin(), found->pairs.end()), expected);
    EXPECT_EQ(found->pairs.size(), expected.size());
  }
}

TEST(SurfaceCrossings, OfSomeTrianglesAreThoseOfAllThatTheyAreIn) {
  const TriangleMesh one = crossingCubes();
  const auto all = findCrossings(one, 1000);
  ASSERT_TRUE(all);
  std::size_t sum = 0;
  for (std::uint32_t i = 0; i < one.triangles.size(); ++i) {
    const auto found = findCrossingsOf(std::array{i}, one);
    ASSERT_TRUE(found);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> expected = all->pairs;
    std::erase_if(expected, [&](const auto& pair) { return pair.first != i && pair.second != i; });
    EXPECT_EQ(found->pairs, expected);
    sum += expected.size();
  }
  EXPECT_EQ(sum, 2 * all->pairs.size());
}

TEST(OuterSurface, CutsTheTrianglesThatMeetOthers) {
  // One far away meets none, so that more triangles are left whole than cut.
  TriangleMesh cubes = crossingCubes();
  const TriangleMesh far = fixtures::translated(fixtures::cube(1), {9, 0, 0});
  const auto first = static_cast<std::uint32_t>(cubes.vertices.size());
  cubes.vertices.insert(cubes.vertices.end(), far.vertices.begin(), far.vertices.end());
  for (const auto& [a, b, c] : far.triangles) {
    cubes.triangles.push_back({a + first, b + first, c + first});
  }
  const auto crossings = findCrossings(cubes, 1000);
  ASSERT_TRUE(crossings);
  std::set<std::uint32_t> meeting;
  for (const auto& [a, b] : crossings->pairs) meeting.insert({a, b});
  const auto outer = outerSurface(cubes, *crossings);
  ASSERT_TRUE(outer) << outer.error().text();
  EXPECT_EQ(outer->cut, meeting.size());
  EXPECT_LT(outer->cut, cubes.triangles.size() / 2);
  EXPECT_NEAR(model::signedVolume(outer->mesh), 3 - 0.3 * 0.4 * 0.45, 1e-12);
}

TEST(SurfaceCrossings, NeighboursThatTouchAreFoundAcrossParts) {
  // Each cube has a face in common with the next, of which the vertices are not shared.
  const TriangleMesh row = copies(fixtures::cube(1), 1, 8000, Point3::Zero(), {1, 0, 0});
  const auto pair = findCrossings(copies(fixtures::cube(1), 1, 2, Point3::Zero(), {1, 0, 0}), 1000);
  ASSERT_TRUE(pair);
  const auto found = findCrossings(row, 10'000'000);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->pairs.size(), 7999 * pair->pairs.size());
  const auto some = findCrossings(row, 100);
  ASSERT_TRUE(some);
  EXPECT_EQ(some->pairs.size(), 100U);
  EXPECT_FALSE(some->complete);
}

}  // namespace
}  // namespace t4d::edit
