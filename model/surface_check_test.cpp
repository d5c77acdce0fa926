#include "model/surface_check.h"

#include <functional>
#include <limits>

#include <gtest/gtest.h>

namespace t4d::model {
namespace {

TriangleMesh tetrahedron() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
          {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}},
          {}};
}

TEST(SurfaceCheck, TetrahedronIsClosedWithVolumeOneSixth) {
  EXPECT_TRUE(checkClosedSurface(tetrahedron()));
  EXPECT_TRUE(isClosed(tetrahedron()));
  EXPECT_NEAR(signedVolume(tetrahedron()), 1.0 / 6, 1e-16);
  EXPECT_NEAR(surfaceArea(tetrahedron()), 1.5 + std::sqrt(3) / 2, 1e-15);
}

TEST(SurfaceCheck, EveryDefectIsNamed) {
  struct Case {
    std::string expected;
    std::function<void(TriangleMesh&)> spoil;
  };
  const Case cases[] = {
      {"no triangles", [](TriangleMesh& m) { m.triangles.clear(); }},
      {"vertex 2 is (0, inf, 0)",
       [](TriangleMesh& m) { m.vertices[2][1] = std::numeric_limits<double>::infinity(); }},
      {"triangle 3 has the vertex 4", [](TriangleMesh& m) { m.triangles[3][0] = 4; }},
      {"triangle 1 (0, 1, 1) has a corner twice", [](TriangleMesh& m) { m.triangles[1][2] = 1; }},
      {"open: 3 boundary edges, the first of triangle 0",
       [](TriangleMesh& m) { m.triangles.pop_back(); }},
      {"has 1 non-manifold edge, with more than two triangles",
       [](TriangleMesh& m) {
         m.vertices.push_back({5, 5, 5});
         m.triangles.insert(m.triangles.end(), {{0, 1, 4}, {1, 0, 4}});
       }},
      {"inconsistent orientation: triangles 0 and 3",
       [](TriangleMesh& m) { std::swap(m.triangles[3][0], m.triangles[3][1]); }},
      {"vertex 0, (0, 0, 0), is non-manifold",
       [](TriangleMesh& m) {
         // A second tetrahedron that touches the first in vertex 0.
         for (int i = 1; i < 4; ++i) m.vertices.push_back(-m.vertices[i]);
         m.triangles.insert(m.triangles.end(), {{0, 4, 5}, {0, 6, 4}, {0, 5, 6}, {4, 6, 5}});
       }},
  };
  for (const Case& one : cases) {
    TriangleMesh mesh = tetrahedron();
    one.spoil(mesh);
    const auto checked = checkClosedSurface(mesh);
    ASSERT_FALSE(checked) << one.expected;
    EXPECT_NE(checked.error().message.find(one.expected), std::string::npos)
        << checked.error().message;
  }
}

TEST(SurfaceCheck, TwoSidesOfATriangleEncloseNothing) {
  const TriangleMesh sides{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 1}}, {}};
  const auto checked = checkClosedSurface(sides);
  ASSERT_FALSE(checked);
  EXPECT_NE(checked.error().message.find("triangles 0 and 1 have the same corners"),
            std::string::npos);
}

TEST(SurfaceCheck, ClosedIsABalanceOfDirections) {
  TriangleMesh mesh = tetrahedron();
  std::swap(mesh.triangles[3][0], mesh.triangles[3][1]);
  EXPECT_FALSE(isClosed(mesh));
  EXPECT_TRUE(isClosed(TriangleMesh{}));
}

}  // namespace
}  // namespace t4d::model
