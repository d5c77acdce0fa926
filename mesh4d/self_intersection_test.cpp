#include <string>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "mesh4d/cap.h"
#include "mesh4d/test_motion.h"
#include "t4d/check.h"
#include "t4d/sweep.h"

namespace t4d::mesh4d {
namespace {

std::string messageOf(const model::TriangleMesh& mesh) {
  const auto checked = checkNoSelfIntersection(mesh);
  EXPECT_FALSE(checked);
  return checked ? "" : checked.error().message;
}

TEST(SelfIntersection, NamesTrianglesAndTheWayOut) {
  model::TriangleMesh mesh = fixtures::cube(2);
  const model::TriangleMesh other = fixtures::cube(2);
  for (const model::Point3& vertex : other.vertices) {
    mesh.vertices.push_back(vertex + model::Point3(0.5, 0.6, 0.7));
  }
  for (const auto& [a, b, c] : other.triangles) mesh.triangles.push_back({a + 8, b + 8, c + 8});
  const auto cap = fillSolid(mesh, CapMethod::TetGen);
  ASSERT_FALSE(cap);
  EXPECT_NE(cap.error().message.find("pairs of triangles"), std::string::npos)
      << cap.error().message;
  EXPECT_EQ(cap.error().remedy, Remedy::ConeCaps);
  model::Mesh swept;
  ASSERT_TRUE(
      sweep(mesh, turnAbout(Eigen::Vector3d::UnitX(), 10), {.caps = CapMethod::Cone}, swept));
  EXPECT_TRUE(measure::checkMesh(swept)->valid());
}

TEST(SelfIntersection, NamesATriangleWithoutArea) {
  // A box whose top edge is split on one side only, by a triangle of no area on the other.
  model::TriangleMesh mesh = fixtures::cube(2);
  const auto [a, b, c] = mesh.triangles[0];
  const auto middle = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.push_back(0.5 * (mesh.vertices[a] + mesh.vertices[b]));
  mesh.triangles[0] = {a, middle, c};
  mesh.triangles.push_back({middle, b, c});
  mesh.triangles.push_back({a, b, middle});
  EXPECT_NE(messageOf(mesh).find("1 triangles have no area (counted from 0: 13)"),
            std::string::npos);
}

TEST(SelfIntersection, IsNotSearchedToTheEndWhereThereAreMany) {
  // Each of the cubes crosses all others: four million pairs and more.
  model::TriangleMesh mesh;
  const model::TriangleMesh cube = fixtures::cube(2);
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const model::Point3& vertex : cube.vertices) {
      mesh.vertices.push_back(vertex + i * model::Point3(1e-4, 2e-4, 3e-4));
    }
    for (const auto& [a, b, c] : cube.triangles) {
      mesh.triangles.push_back({a + first, b + first, c + first});
    }
  }
  EXPECT_NE(messageOf(mesh).find("at least 1000 pairs"), std::string::npos);
}

}  // namespace
}  // namespace t4d::mesh4d
