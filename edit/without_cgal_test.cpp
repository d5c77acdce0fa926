#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "t4d/edit.h"

namespace t4d::edit {
namespace {

using model::TriangleMesh;

TEST(WithoutCgal, MergesTurnsAndDropsButFillsNoHole) {
  const TriangleMesh cube = fixtures::cube(2);
  TriangleMesh soup;
  for (const auto& triangle : cube.triangles) {
    for (const std::uint32_t corner : triangle) soup.vertices.push_back(cube.vertices[corner]);
    const auto next = static_cast<std::uint32_t>(soup.vertices.size());
    soup.triangles.push_back({next - 3, next - 2, next - 1});
  }
  std::swap(soup.triangles[4][0], soup.triangles[4][1]);
  soup.triangles.push_back(soup.triangles[2]);
  TriangleMesh mesh = soup;
  const auto report = mendSurface(mesh);
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_EQ(report->changes.size(), 3U);
  EXPECT_EQ(mesh.vertices.size(), 8U);
  EXPECT_NEAR(signedVolume(mesh), 8, 1e-12);
  EXPECT_FALSE(report->selfIntersections);

  soup.triangles.resize(10);
  const auto open = mendSurface(soup);
  ASSERT_FALSE(open);
  EXPECT_NE(open.error().message.find("has no CGAL"), std::string::npos);
}

TEST(WithoutCgal, TakesApartWhatTouches) {
  TriangleMesh mesh = fixtures::cube(2);
  for (const auto& [a, b, c] : fixtures::cube(2).triangles) {
    mesh.triangles.push_back({a + 8, b + 8, c + 8});
  }
  for (int i = 0; i < 8; ++i) mesh.vertices.emplace_back(mesh.vertices[i] + model::Point3(2, 2, 2));
  const auto report = mendSurface(mesh);
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_EQ(report->components, 2U);
  EXPECT_NEAR(signedVolume(mesh), 16, 1e-3);
}

}  // namespace
}  // namespace t4d::edit
