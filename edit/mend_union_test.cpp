/// mendSurface decides by winding numbers: what it keeps of solids that share faces, edges and
/// corners, and of surfaces with two sides.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "edit/mend_steps.h"
#include "fixtures/solids.h"
#include "t4d/edit.h"

namespace t4d::edit {
namespace {

using model::Point3;
using model::Triangle;
using model::TriangleMesh;

void addSolid(TriangleMesh& mesh, const TriangleMesh& other) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const auto& [a, b, c] : other.triangles) {
    mesh.triangles.push_back({a + first, b + first, c + first});
  }
}

/// A box that faces outward. `axis` chooses the diagonals of its sides.
TriangleMesh boxOf(const Point3& low, const Point3& high, int axis = 0) {
  TriangleMesh mesh = fixtures::cube(2);
  for (Point3& vertex : mesh.vertices) {
    const Point3 turned(vertex[axis], vertex[(axis + 1) % 3], vertex[(axis + 2) % 3]);
    vertex = low + (0.5 * (turned + Point3::Ones())).cwiseProduct(high - low);
  }
  return mesh;
}

TriangleMesh turnedAboutZ(TriangleMesh mesh, double degrees) {
  const Eigen::AngleAxisd turn(degrees * std::numbers::pi / 180, Point3::UnitZ());
  for (Point3& vertex : mesh.vertices) vertex = turn * vertex;
  return mesh;
}

/// The report, or nothing; the mesh becomes the mended one, which must bound a solid.
std::optional<MendSurfaceReport> mendedWell(TriangleMesh& mesh) {
  auto report = mendSurface(mesh);
  if (!report) {
    ADD_FAILURE() << report.error().text();
    return {};
  }
  EXPECT_TRUE(*isSound(mesh));
  EXPECT_EQ(report->volumeAfter, signedVolume(mesh));
  return std::move(*report);
}

double volumeOfMended(TriangleMesh mesh) {
  const auto report = mendedWell(mesh);
  return report ? report->volumeAfter : std::nan("");
}

TEST(MendUnion, OfBoxesThatShareAnEdgeACornerOrAFace) {
  for (const int axis : {0, 1, 2}) {
    SCOPED_TRACE(axis);
    TriangleMesh corner = boxOf({0, 0, 0}, {2, 1, 1}, axis);
    addSolid(corner, boxOf({0, 0, 0}, {1, 2, 1}));
    EXPECT_NEAR(volumeOfMended(corner), 3, 1e-12);
    TriangleMesh within = boxOf({0, 0, 0}, {2, 2, 1}, axis);
    addSolid(within, boxOf({0, 0, 0}, {1, 1, 1}));
    EXPECT_NEAR(volumeOfMended(within), 4, 1e-12);
    TriangleMesh end = boxOf({0, 0, 0}, {2, 1, 1}, axis);
    addSolid(end, boxOf({0, 0, 0}, {1, 1, 1}));
    EXPECT_NEAR(volumeOfMended(end), 2, 1e-12);
    TriangleMesh beside = boxOf({0, 0, 0}, {1, 1, 1}, axis);
    addSolid(beside, boxOf({1, 0, 0}, {2, 1, 1}));
    EXPECT_NEAR(volumeOfMended(beside), 2, 1e-12);
    EXPECT_NEAR(volumeOfMended(boxOf({0, 0, 0}, {2, 1, 1}, axis)), 2, 1e-12);
  }
}

TEST(MendUnion, OfCubesThatAreTurnedAboutTheirCommonEdge) {
  const TriangleMesh cube = boxOf({0, 0, 0}, {1, 1, 1});
  for (const double degrees : {10.0, 30.0, 45.0, 60.0, 80.0}) {
    TriangleMesh both = cube;
    addSolid(both, turnedAboutZ(cube, degrees));
    // Squares that are turned about a corner overlap in a kite of the area tan(45 - degrees / 2).
    const double overlap = std::tan((45 - degrees / 2) * std::numbers::pi / 180);
    EXPECT_NEAR(volumeOfMended(both), 2 - overlap, 1e-12) << degrees;
  }
  // From 90 degrees on they only touch, and are taken apart.
  TriangleMesh touching = cube;
  addSolid(touching, turnedAboutZ(cube, 120));
  EXPECT_NEAR(volumeOfMended(touching), 2, 1e-4);
}

TEST(MendUnion, OfTetrahedraInEachOtherThatShareAnEdgeAlone) {
  const auto tetrahedron = [](double width) {
    return TriangleMesh{{{0, 0, 0}, {0, 0, 1}, {width, 0, 0.5}, {0, width, 0.5}},
                        {{0, 1, 3}, {0, 2, 1}, {0, 3, 2}, {1, 2, 3}},
                        {}};
  };
  TriangleMesh outer = tetrahedron(1);
  ASSERT_NEAR(std::abs(signedVolume(outer)), 1.0 / 6, 1e-15);
  TriangleMesh inner = tetrahedron(0.25);
  // The inner one is within the wedge of the outer one.
  inner.vertices[2] = {0.3, 0.1, 0.5};
  inner.vertices[3] = {0.1, 0.3, 0.5};
  for (TriangleMesh* mesh : {&outer, &inner}) {
    if (signedVolume(*mesh) > 0) continue;
    for (Triangle& triangle : mesh->triangles) reverse(triangle);
  }
  TriangleMesh nested = outer;
  addSolid(nested, inner);
  EXPECT_NEAR(volumeOfMended(nested), 1.0 / 6, 1e-12);
}

TEST(MendUnion, StaysRightWhereOneTriangleIsTurned) {
  TriangleMesh corner = boxOf({0, 0, 0}, {2, 1, 1});
  addSolid(corner, boxOf({0, 0, 0}, {1, 2, 1}));
  TriangleMesh end = boxOf({0, 0, 0}, {2, 1, 1});
  addSolid(end, boxOf({0, 0, 0}, {1, 1, 1}));
  for (const auto& [given, volume] : {std::pair(corner, 3.0), std::pair(end, 2.0)}) {
    for (std::size_t i = 0; i < given.triangles.size(); ++i) {
      TriangleMesh mesh = given;
      reverse(mesh.triangles[i]);
      EXPECT_NEAR(volumeOfMended(mesh), volume, 1e-12) << volume << ' ' << i;
    }
  }
}

TEST(MendUnion, StaysRightWhereASolidIsInsideOut) {
  TriangleMesh mesh = boxOf({0, 0, 0}, {2, 1, 1});
  TriangleMesh other = boxOf({2, 1, 0}, {3, 2, 1}, 1);
  for (Triangle& triangle : other.triangles) reverse(triangle);
  addSolid(mesh, other);
  EXPECT_NEAR(volumeOfMended(mesh), 3, 1e-3);
}

/// Whether a cell of a small lattice is in one of the boxes.
struct LatticeBox {
  std::array<int, 3> low;
  std::array<int, 3> high;
};

int cellsIn(const std::vector<LatticeBox>& boxes, int size) {
  int count = 0;
  for (int x = 0; x < size; ++x) {
    for (int y = 0; y < size; ++y) {
      for (int z = 0; z < size; ++z) {
        count += std::ranges::any_of(boxes, [&](const LatticeBox& box) {
          return box.low[0] <= x && x < box.high[0] && box.low[1] <= y && y < box.high[1] &&
                 box.low[2] <= z && z < box.high[2];
        });
      }
    }
  }
  return count;
}

constexpr int kLattice = 4;

/// Two to five boxes on the lattice, which share faces, edges and corners.
std::vector<LatticeBox> randomBoxes(std::mt19937& random) {
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  std::vector<LatticeBox> boxes(2 + below(4));
  for (LatticeBox& box : boxes) {
    for (int axis = 0; axis < 3; ++axis) {
      box.low[axis] = below(kLattice);
      box.high[axis] = box.low[axis] + 1 + below(kLattice - box.low[axis]);
    }
  }
  return boxes;
}

TriangleMesh meshOf(const std::vector<LatticeBox>& boxes, std::mt19937& random) {
  TriangleMesh mesh;
  for (const auto& [low, high] : boxes) {
    addSolid(mesh, boxOf(Point3(low[0], low[1], low[2]), Point3(high[0], high[1], high[2]),
                         static_cast<int>(random() % 3)));
  }
  return mesh;
}

/// What touches along an edge is taken apart, which moves it by 1e-5 of the diagonal.
bool isTakenApart(const MendSurfaceReport& report) {
  return std::ranges::any_of(report.changes, [](const SurfaceChange& change) {
    return change.kind == SurfaceFault::NonManifold;
  });
}

TEST(MendUnion, OfBoxesOnALatticeHasTheVolumeOfItsCells) {
  constexpr int kSeeds = 150;
  int touching = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    std::mt19937 random(seed);
    const std::vector<LatticeBox> boxes = randomBoxes(random);
    TriangleMesh mesh = meshOf(boxes, random);
    const auto report = mendedWell(mesh);
    ASSERT_TRUE(report) << seed;
    touching += isTakenApart(*report) ? 1 : 0;
    EXPECT_NEAR(report->volumeAfter, cellsIn(boxes, kLattice), isTakenApart(*report) ? 1e-2 : 1e-12)
        << seed;
    EXPECT_EQ(report->lost.triangles, 0U) << seed;
    TriangleMesh again = mesh;
    const auto second = mendSurface(again);
    ASSERT_TRUE(second) << seed;
    EXPECT_TRUE(second->changes.empty()) << seed << ": " << second->changes.front().text;
  }
  EXPECT_GT(touching, 10);
}

TEST(MendUnion, OfBoxesOnALatticeStaysRightWithADefect) {
  constexpr int kSeeds = 150;
  for (int seed = 0; seed < kSeeds; ++seed) {
    std::mt19937 random(seed);
    const std::vector<LatticeBox> boxes = randomBoxes(random);
    TriangleMesh mesh = meshOf(boxes, random);
    const std::size_t at = random() % mesh.triangles.size();
    const auto [a, b, c] = mesh.triangles[at];
    switch (seed % 4) {
      case 0:
        reverse(mesh.triangles[at]);
        break;
      case 1:
        mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(at));
        break;
      case 2:
        mesh.triangles.push_back({a, b, c});
        break;
      default:
        mesh.triangles.push_back({a, c, b});
    }
    const auto report = mendedWell(mesh);
    ASSERT_TRUE(report) << seed;
    EXPECT_NEAR(report->volumeAfter, cellsIn(boxes, kLattice), isTakenApart(*report) ? 1e-2 : 1e-12)
        << seed;
    EXPECT_EQ(report->lost.triangles, 0U) << seed;
  }
}

TEST(MendTwoSided, SheetsEncloseNothing) {
  const TriangleMesh cube = boxOf({0, 0, 0}, {1, 1, 1});
  TriangleMesh sheets = cube;
  sheets.triangles = {{0, 1, 2}, {0, 2, 1}};
  for (const std::size_t count : {1, 3, 5, 11}) {
    sheets.triangles.clear();
    for (std::size_t i = 0; i < count; ++i) {
      const auto [a, b, c] = cube.triangles[i];
      sheets.triangles.push_back({a, b, c});
      sheets.triangles.push_back({a, c, b});
    }
    TriangleMesh mesh = sheets;
    const auto report = mendSurface(mesh);
    ASSERT_FALSE(report) << count;
    EXPECT_NE(report.error().message.find("encloses nothing"), std::string::npos);
  }
}

TEST(MendTwoSided, ClosedSurfacesAreThoseOfASolid) {
  TriangleMesh mesh = boxOf({0, 0, 0}, {1, 1, 1});
  addSolid(mesh, boxOf({1, 0, 0}, {2, 1, 1}));
  const std::vector<Triangle> once = mesh.triangles;
  for (const auto& [a, b, c] : once) mesh.triangles.push_back({a, c, b});
  EXPECT_NEAR(volumeOfMended(mesh), 2, 1e-12);
}

TEST(MendTwoSided, WallsBetweenSolidsCancel) {
  // 27 cubes, of which the one in the middle is all walls.
  TriangleMesh mesh;
  for (int i = 0; i < 27; ++i) {
    const Point3 low(i % 3, i / 3 % 3, i / 9);  // NOLINT(bugprone-integer-division)
    addSolid(mesh, boxOf(low, low + Point3::Ones()));
  }
  EXPECT_NEAR(volumeOfMended(mesh), 27, 1e-12);
}

TEST(MendLost, IsWhatTheInputHadOutsideOfTheSolid) {
  // A fin that reaches 3 out of the cube, a sheet with two sides beside it, and a wall within it.
  const TriangleMesh cube = boxOf({0, 0, 0}, {1, 1, 1});
  TriangleMesh fin = cube;
  fin.vertices.emplace_back(0.5, 0.5, 4);
  fin.triangles.push_back({cube.triangles[0][0], cube.triangles[0][1], 8});
  auto report = mendedWell(fin);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->lost.triangles, 1U);
  EXPECT_NEAR(report->lost.distance, 3, 1e-12);
  EXPECT_NEAR(report->boundsBefore.max.z(), 4, 0);
  EXPECT_NEAR(report->boundsAfter.max.z(), 1, 0);

  TriangleMesh sheet = cube;
  addSolid(sheet, {{{3, 0, 0}, {3, 1, 0}, {3, 0, 1}}, {{0, 1, 2}, {0, 2, 1}}, {}});
  report = mendedWell(sheet);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->lost.triangles, 1U);
  EXPECT_NEAR(report->lost.distance, 2, 1e-12);

  TriangleMesh wall = cube;
  addSolid(wall, {{{0.2, 0.2, 0.2}, {0.8, 0.2, 0.2}, {0.2, 0.8, 0.7}}, {{0, 1, 2}, {0, 2, 1}}, {}});
  addSolid(wall, boxOf({0.5, 0.5, 0.5}, {0.75, 0.75, 0.75}));
  report = mendedWell(wall);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->lost.triangles, 0U);
  EXPECT_GT(report->hausdorff, 0.1);

  TriangleMesh hole = cube;
  hole.triangles.pop_back();
  report = mendedWell(hole);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->lost.triangles, 0U);
}

}  // namespace
}  // namespace t4d::edit
