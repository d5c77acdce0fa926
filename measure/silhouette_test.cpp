#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "measure/winding_number.h"
#include "t4d/check.h"
#include "t4d/envelope.h"
#include "t4d/mesh.h"
#include "t4d/sweep.h"

namespace t4d::measure {
namespace {

using model::Point3;

model::Mesh swept(const model::TriangleMesh& solid, const model::Motion& motion,
                  const mesh4d::SweepOptions& options = {}) {
  model::Mesh mesh;
  EXPECT_TRUE(mesh4d::sweep(solid, motion, options, mesh));
  return mesh;
}

model::Motion screws(const std::vector<model::ScrewRun>& runs) {
  auto motion = model::chainScrews(0, runs);
  EXPECT_TRUE(motion);
  return *motion;
}

model::Motion screw(const Point3& axis, double degrees, const Point3& translation) {
  return screws({{1, {Point3::Zero(), axis.normalized(), degrees, translation}, 1}});
}

Silhouette of(const model::Mesh& mesh) {
  auto silhouette = silhouetteOf(mesh);
  EXPECT_TRUE(silhouette) << (silhouette ? "" : silhouette.error().text());
  return silhouette ? *silhouette : Silhouette{};
}

double hypervolumeOf(const model::Mesh& mesh) { return checkMesh(mesh)->hypervolume; }

int visits(const Silhouette& silhouette, const Point3& place) {
  return static_cast<int>(std::lround(WindingNumber(silhouette.surface).exactAt(place)));
}

/// Twice the area of a convex solid's shadow along a direction: each triangle counts once on each
/// side.
double shadow(const model::TriangleMesh& solid, const Point3& direction) {
  double area = 0;
  for (const auto& [a, b, c] : solid.triangles) {
    const Point3 normal =
        (solid.vertices[b] - solid.vertices[a]).cross(solid.vertices[c] - solid.vertices[a]);
    area += std::abs(normal.dot(direction)) / 4;
  }
  return area;
}

TEST(Silhouette, OfThePapersCubeEncloses33600) {
  const Silhouette silhouette = of(swept(
      fixtures::paperCube(), screws({{1, {Point3::Zero(), Point3::UnitZ(), 0, {0, 0, 1}}, 64}})));
  EXPECT_NEAR(silhouette.visitsVolume, 33600, 1e-9);
  EXPECT_NEAR(silhouette.hypervolume, 64 * 8000, 1e-8);
  EXPECT_TRUE(model::isClosed(silhouette.surface));
  EXPECT_NEAR(model::signedVolume(silhouette.surface), 33600, 1e-9);
}

TEST(Silhouette, OfAConvexSolidMovedStraightEnclosesItsShadow) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const model::TriangleMesh ball = fixtures::icosphere(2, 2);
  const double volume = model::signedVolume(ball);
  for (int round = 0; round < 8; ++round) {
    const Point3 along(3 * normal(random), 3 * normal(random), 3 * normal(random));
    const model::Mesh mesh = swept(ball, screw(Point3::UnitZ(), 0, along));
    const double expected = volume + shadow(ball, along);
    const Silhouette silhouette = of(mesh);
    EXPECT_NEAR(silhouette.visitsVolume / expected, 1, 1e-12);
    EXPECT_NEAR(model::signedVolume(silhouette.surface) / expected, 1, 1e-12);
    EXPECT_NEAR(silhouette.hypervolume / volume, 1, 1e-12);
    EXPECT_EQ(visits(silhouette, 0.5 * along), 1);
    EXPECT_EQ(visits(silhouette, 2.5 * along + Point3(4, 4, 4)), 0);
  }
}

TEST(Silhouette, WindsAsOftenAsAPlaceIsVisited) {
  // A small cube that goes round one and a half times.
  model::TriangleMesh cube = fixtures::cube(1);
  for (Point3& vertex : cube.vertices) vertex.x() += 5;
  const Silhouette silhouette = of(swept(cube, screw(Point3::UnitZ(), 540, Point3::Zero())));
  EXPECT_TRUE(model::isClosed(silhouette.surface));
  EXPECT_EQ(visits(silhouette, {0.01, 5.02, 0.1}), 2);
  EXPECT_EQ(visits(silhouette, {0.01, -5.02, 0.1}), 1);
  EXPECT_EQ(visits(silhouette, {0.01, 0.02, 0.1}), 0);
  EXPECT_EQ(visits(silhouette, {0.01, 5.02, 0.6}), 0);
}

TEST(Silhouette, IsTheSameForConesAsCaps) {
  // A cone's cells overlap within the cap, where the solid has never been.
  const model::TriangleMesh torus = fixtures::torus(4, 1, 24, 12);
  const model::Motion motion = screw({1, 2, 3}, 35, {1, 0.5, 3});
  const Silhouette filled = of(swept(torus, motion));
  const model::Mesh mesh = swept(torus, motion, {.caps = mesh4d::CapMethod::Cone});
  const Silhouette cones = of(mesh);
  EXPECT_NEAR(cones.visitsVolume / filled.visitsVolume, 1, 1e-12);
  EXPECT_NEAR(cones.hypervolume / hypervolumeOf(mesh), 1, 1e-12);
  EXPECT_EQ(visits(cones, {0.1, 0.2, -3}), 0);
  EXPECT_EQ(cones.surface.triangles.size(), filled.surface.triangles.size());
}

TEST(Silhouette, SumsTheProjectedExitsAndTheDwell) {
  const model::Mesh mesh = swept(fixtures::pebble(3, 200), screw({1, 2, 3}, 200, {1, 5, -3}));
  const Silhouette silhouette = of(mesh);
  EXPECT_TRUE(model::isClosed(silhouette.surface));
  EXPECT_NEAR(model::signedVolume(silhouette.surface) / silhouette.visitsVolume, 1, 1e-11);
  EXPECT_NEAR(silhouette.hypervolume / hypervolumeOf(mesh), 1, 1e-11);
}

TEST(Silhouette, OfASmallSolidThatMovesFarHasItsDwellToRounding) {
  model::TriangleMesh cube = fixtures::cube(0.01);
  const double volume = model::signedVolume(cube);
  for (const double place : {0.0, 1e3}) {
    for (Point3& vertex : cube.vertices) vertex.x() += place;
    const Silhouette silhouette = of(swept(cube, screw(Point3::UnitZ(), 0, {10, 10, 10})));
    const double tolerance = place > 0 ? 1e-9 : 1e-12;  // that of the vertices' places
    EXPECT_NEAR(silhouette.hypervolume / volume, 1, tolerance);
    EXPECT_NEAR(silhouette.hypervolume / silhouette.hypervolumeByFlux, 1, tolerance);
  }
}

TEST(Silhouette, OfASlabIsWhereTheSolidHasBeenDuringIt) {
  const model::TriangleMesh ball = fixtures::icosphere(2, 2);
  const model::Mesh mesh =
      swept(ball, screws({{1, {Point3::Zero(), Point3::UnitZ(), 0, {3, 1, 2}}, 4}}));
  SlabSilhouettes slabs;
  double hypervolume = 0;
  int steps = 0;
  for (const model::Slab& slab : mesh.slabs()) {
    const auto silhouette = slabs.of(slab);
    ASSERT_TRUE(silhouette);
    EXPECT_TRUE(model::isClosed(silhouette->surface));
    hypervolume += silhouette->hypervolume;
    if (slab.timeBegin == slab.timeEnd) {
      EXPECT_TRUE(silhouette->surface.triangles.empty());
      continue;
    }
    ++steps;
    const double expected = model::signedVolume(ball) + shadow(ball, {3, 1, 2});
    EXPECT_NEAR(silhouette->visitsVolume / expected, 1, 1e-12);
    EXPECT_NEAR(model::signedVolume(silhouette->surface) / expected, 1, 1e-12);
    EXPECT_EQ(visits(*silhouette, Point3(3, 1, 2) * (slab.timeBegin + 0.5)), 1);
    EXPECT_EQ(visits(*silhouette, Point3(3, 1, 2) * (slab.timeBegin - 0.9)), 0);
  }
  EXPECT_EQ(steps, 4);
  EXPECT_NEAR(hypervolume / hypervolumeOf(mesh), 1, 1e-12);
}

TEST(Silhouette, RefusesMeshesThatAreNotClosed) {
  const model::Mesh mesh = swept(fixtures::cube(1), screw(Point3::UnitZ(), 40, {1, 2, 3}));
  SilhouetteBuilder withoutCaps;
  for (const model::Slab& slab : mesh.slabs().subspan(1, 1)) {
    const auto put = withoutCaps.put(slab);
    ASSERT_FALSE(put);
    EXPECT_EQ(put.error().text(),
              "slab 0: the mesh is not closed at time 0: the cells before and after it do not fit "
              "together");
  }
  SilhouetteBuilder withoutEnd;
  for (const model::Slab& slab : mesh.slabs().first(mesh.slabCount() - 1)) {
    ASSERT_TRUE(withoutEnd.put(slab));
  }
  EXPECT_FALSE(withoutEnd.finish());
  SilhouetteBuilder holed;
  for (model::Slab slab : mesh.slabs()) {
    auto fewer = std::make_shared<model::Connectivity>(*slab.connectivity);
    fewer->cellAttributes.clear();
    if (slab.timeBegin < slab.timeEnd) fewer->cells.pop_back();
    slab.connectivity = fewer;
    if (auto put = holed.put(slab); !put) {
      EXPECT_NE(put.error().text().find("the mesh is not closed"), std::string::npos);
      return;
    }
  }
  FAIL();
}

}  // namespace
}  // namespace t4d::measure
