#include "measure/lattice_surface.h"

#include <cmath>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "measure/surface_genus.h"
#include "model/surface_check.h"

namespace t4d::measure {
namespace {

using model::Point3;
using model::TriangleMesh;

VisitLattice visitsOf(const TriangleMesh& mesh, double spacing) {
  auto lattice = SpaceLattice::about(model::boundsOf(mesh), spacing);
  EXPECT_TRUE(lattice) << (lattice ? "" : lattice.error().text());
  return {mesh, std::move(*lattice)};
}

TriangleMesh turned(TriangleMesh mesh, double angle, const Point3& axis) {
  const Eigen::AngleAxisd turn(angle, axis.normalized());
  for (Point3& vertex : mesh.vertices) vertex = turn * vertex;
  return mesh;
}

TEST(LatticeSurface, OfABoxAlongTheAxesIsTheBox) {
  const VisitLattice visits = visitsOf(fixtures::cube(7), 0.83);
  const LatticeSurface surface(visits);
  EXPECT_TRUE(model::checkClosedSurface(surface.mesh()));
  EXPECT_NEAR(model::signedVolume(surface.mesh()), 343, 1e-9);
  EXPECT_NEAR(model::surfaceArea(surface.mesh()), 6 * 49, 1e-9);
}

TEST(LatticeSurface, KeepsSharpEdgesOfATurnedBox) {
  const TriangleMesh box = turned(fixtures::cube(7), 0.7, {1, 2, 3});
  for (const double spacing : {0.83, 0.21}) {
    const VisitLattice visits = visitsOf(box, spacing);
    const LatticeSurface surface(visits);
    EXPECT_TRUE(model::checkClosedSurface(surface.mesh()));
    // Without features it would lack 0.05 h^2 for each unit of its edges.
    EXPECT_NEAR(model::signedVolume(surface.mesh()), 343, 0.02 * spacing * spacing * 84);
  }
}

TEST(LatticeSurface, ConvergesWithTheSecondOrder) {
  const TriangleMesh ball = fixtures::icosphere(2, 6);
  const double volume = model::signedVolume(ball);
  for (const double spacing : {0.4, 0.2, 0.1}) {
    const VisitLattice visits = visitsOf(ball, spacing);
    const LatticeSurface surface(visits);
    EXPECT_TRUE(model::checkClosedSurface(surface.mesh()));
    EXPECT_EQ(generaOf(surface.mesh()), std::vector<double>{0});
    EXPECT_NEAR(model::signedVolume(surface.mesh()), volume, 0.2 * spacing * spacing);
    double farthest = 0;
    for (const auto& [a, b, c] : surface.mesh().triangles) {
      const auto& v = surface.mesh().vertices;
      farthest = std::max(farthest, std::abs(((v[a] + v[b] + v[c]) / 3).norm() - 2));
    }
    EXPECT_LT(farthest, spacing * spacing / 4);
  }
}

TEST(LatticeSurface, IsAManifoldForRandomSigns) {
  // Many small balls, as near to each other as the lattice is fine: every kind of cube.
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(0, 6);
  TriangleMesh heap;
  const TriangleMesh one = fixtures::icosphere(0.4, 0);
  for (int i = 0; i < 400; ++i) {
    const Point3 by(uniform(random), uniform(random), uniform(random));
    const auto first = static_cast<std::uint32_t>(heap.vertices.size());
    for (const Point3& vertex : one.vertices) heap.vertices.push_back(vertex + by);
    for (const auto& [a, b, c] : one.triangles) {
      heap.triangles.push_back({a + first, b + first, c + first});
    }
  }
  for (const double spacing : {0.5, 0.4, 0.3}) {
    const VisitLattice visits = visitsOf(heap, spacing);
    LatticeSurface surface(visits);
    EXPECT_TRUE(model::checkClosedSurface(surface.mesh()));
    EXPECT_GT(model::signedVolume(surface.mesh()), 0);
    std::vector<std::uint32_t> all(surface.mesh().triangles.size());
    std::iota(all.begin(), all.end(), 0U);
    EXPECT_TRUE(surface.makePlain(all));
    EXPECT_TRUE(model::checkClosedSurface(surface.mesh()));
    EXPECT_FALSE(surface.makePlain(all));
  }
}

}  // namespace
}  // namespace t4d::measure
