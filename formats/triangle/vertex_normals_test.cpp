#include "formats/triangle/vertex_normals.h"

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "t4d/surface.h"

namespace t4d::formats {
namespace {

TEST(VertexNormals, ACubeHasSixPlanesAndEightCorners) {
  const model::TriangleMesh cube = fixtures::cube(2);
  EXPECT_EQ(withNormals(cube, {.flat = true}).normals.size(), 36U);
  EXPECT_EQ(withNormals(cube, {.creaseDegrees = 30}).normals.size(), 24U);
  const VerticesWithNormals smooth = withNormals(cube, {});
  ASSERT_EQ(smooth.normals.size(), 8U);
  for (std::size_t i = 0; i < 8; ++i) {
    // Weighted by angles, the normal at a corner is its diagonal, however squares are divided.
    const Eigen::Vector3f diagonal = cube.vertices[smooth.sources[i]].normalized().cast<float>();
    EXPECT_LT((smooth.normals[i] - diagonal).norm(), 1e-6F);
  }
  const VerticesWithNormals crease = withNormals(cube, {.creaseDegrees = 89.9});
  for (std::size_t i = 0; i < crease.triangles.size(); ++i) {
    const auto& t = cube.triangles[i];
    const auto& v = cube.vertices;
    const Eigen::Vector3d normal = (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]).normalized();
    for (int corner = 0; corner < 3; ++corner) {
      const std::uint32_t at = crease.triangles[i][corner];
      EXPECT_EQ(crease.sources[at], t[corner]);
      EXPECT_LT((crease.normals[at] - normal.cast<float>()).norm(), 1e-6F);
    }
  }
}

TEST(VertexNormals, OfASphereAreItsRadii) {
  const model::TriangleMesh sphere = fixtures::icosphere(3, 3);
  for (const double crease : {30.0, 180.0}) {
    const VerticesWithNormals made = withNormals(sphere, {.creaseDegrees = crease});
    ASSERT_EQ(made.normals.size(), sphere.vertices.size());
    for (std::size_t i = 0; i < made.normals.size(); ++i) {
      const Eigen::Vector3f radius = sphere.vertices[made.sources[i]].cast<float>() / 3;
      EXPECT_LT((made.normals[i] - radius).norm(), 0.02F);
    }
  }
}

TEST(VertexNormals, HaveLengthOneWhateverTheTriangles) {
  model::TriangleMesh flat;
  flat.vertices = {{0, 0, 0},     {1, 0, 0},      {2, 0, 0},     {1e200, 0, 0},
                   {0, 1e200, 0}, {1e-200, 0, 0}, {0, 1e-200, 0}};
  flat.triangles = {{0, 1, 2}, {0, 0, 0}, {0, 3, 4}, {0, 5, 6}};
  for (const NormalStyle& style : {NormalStyle{true, 0}, NormalStyle{false, 0}, NormalStyle{}}) {
    for (const Eigen::Vector3f& normal : withNormals(flat, style).normals) {
      EXPECT_NEAR(normal.norm(), 1, 1e-6);
    }
  }
  EXPECT_TRUE(withNormals({}, {}).normals.empty());
}

}  // namespace
}  // namespace t4d::formats
