#include "model/surface_edges.h"

#include <algorithm>
#include <map>
#include <random>
#include <utility>

#include <gmock/gmock.h>

namespace t4d::model {
namespace {

using ::testing::ElementsAre;

/// Two tetrahedra with a common edge, 0 1: counter-clockwise seen from outside.
TriangleMesh touchingTetrahedra() {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
  mesh.triangles = {{0, 3, 2}, {0, 2, 1}, {2, 3, 1}, {3, 0, 1},
                    {0, 5, 4}, {0, 4, 1}, {4, 5, 1}, {5, 0, 1}};
  return mesh;
}

TEST(SurfaceEdges, AreInOrderOfTheirVerticesWithSidesInOrder) {
  std::mt19937 random(1);
  const auto vertex = [&] { return static_cast<std::uint32_t>(random() % 30); };
  std::vector<Triangle> triangles;
  while (triangles.size() < 500) {
    const Triangle triangle = {vertex(), vertex(), vertex()};
    const auto& [a, b, c] = triangle;
    if (a != b && b != c && c != a) triangles.push_back(triangle);
  }
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<std::uint32_t>> expected;
  for (std::uint32_t side = 0; side < 3 * triangles.size(); ++side) {
    const Triangle& triangle = triangles[side / 3];
    expected[std::minmax(triangle[side % 3], triangle[(side + 1) % 3])].push_back(side);
  }
  const SurfaceEdges found = edgesOf(triangles);
  ASSERT_EQ(found.edges.size(), expected.size());
  ASSERT_EQ(found.sides.size(), 3 * triangles.size());
  auto next = expected.begin();
  for (const auto& [low, high, begin, end] : found.edges) {
    EXPECT_EQ(std::pair(low, high), next->first);
    EXPECT_EQ(std::vector(found.sides.begin() + begin, found.sides.begin() + end), next->second);
    ++next;
  }
}

TEST(SurfaceEdges, OfNothingAreNone) {
  EXPECT_TRUE(edgesOf({}).sides.empty());
  EXPECT_TRUE(edgesOf({}).edges.empty());
}

TEST(SurfaceEdges, MatesAreTrianglesWithSolidBetweenThem) {
  const TriangleMesh mesh = touchingTetrahedra();
  const auto mates = matesOf(mesh, edgesOf(mesh.triangles));
  for (std::uint32_t side = 0; side < mates.size(); ++side) {
    EXPECT_EQ(mates[mates[side]], side);
    EXPECT_EQ(mates[side] / 12, side / 12) << "the other tetrahedron at side " << side;
  }
}

TEST(SurfaceEdges, BoundaryLoopsFollowTheTriangles) {
  TriangleMesh mesh = touchingTetrahedra();
  mesh.triangles.erase(mesh.triangles.begin() + 2);  // 2 3 1
  const SurfaceEdges edges = edgesOf(mesh.triangles);
  EXPECT_THAT(boundaryLoops(mesh, edges), ElementsAre(ElementsAre(1, 3, 2)));
  EXPECT_EQ(std::ranges::count(matesOf(mesh, edges), kNoIndex), 3);
}

}  // namespace
}  // namespace t4d::model
