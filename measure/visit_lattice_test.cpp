#include "measure/visit_lattice.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "measure/winding_number.h"

namespace t4d::measure {
namespace {

using model::Point3;
using model::TriangleMesh;

/// Both surfaces in one mesh.
TriangleMesh bothOf(TriangleMesh a, const TriangleMesh& b) {
  const auto first = static_cast<std::uint32_t>(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& [p, q, r] : b.triangles) {
    a.triangles.push_back({p + first, q + first, r + first});
  }
  return a;
}

VisitLattice latticeOf(const TriangleMesh& mesh, double spacing) {
  auto lattice = SpaceLattice::about(model::boundsOf(mesh), spacing);
  EXPECT_TRUE(lattice) << (lattice ? "" : lattice.error().text());
  return {mesh, std::move(*lattice)};
}

template <class Visit>
void eachPoint(const SpaceLattice& lattice, Visit visit) {
  for (std::uint32_t x = 0; x < lattice.at[0].size(); ++x) {
    for (std::uint32_t y = 0; y < lattice.at[1].size(); ++y) {
      for (std::uint32_t z = 0; z < lattice.at[2].size(); ++z) {
        visit(LatticeIndex{x, y, z}, Point3(lattice.at[0][x], lattice.at[1][y], lattice.at[2][z]));
      }
    }
  }
}

TEST(VisitLattice, HasTheWindingNumbersOfTheSurface) {
  const TriangleMesh mesh =
      bothOf(fixtures::pebble(3, 120),
             fixtures::translated(fixtures::torus(2, 0.7, 12, 8), {1.2, 0.3, 0.4}));
  const VisitLattice visits = latticeOf(mesh, 0.61);
  const WindingNumber winding(mesh);
  int most = 0;
  eachPoint(visits.lattice(), [&](const LatticeIndex& index, const Point3& point) {
    EXPECT_EQ(visits.winding(index), std::lround(winding.exactAt(point)));
    most = std::max(most, visits.winding(index));
  });
  EXPECT_EQ(most, 2);
}

TEST(VisitLattice, TellsSidesWherePointsLieOnTheSurface) {
  // Lattice points on faces, edges and vertices of a cube and in planes of its triangles: each is
  // on one side, the same for lines in all directions, and the count is that of a half-open cube.
  const TriangleMesh mesh =
      bothOf(fixtures::cube(4), fixtures::translated(fixtures::cube(10), {0.25, 0.25, 0.25}));
  auto lattice = SpaceLattice::about(model::boundsOf(mesh), 1);
  ASSERT_TRUE(lattice);
  for (auto& at : lattice->at) {
    for (double& c : at) c = std::floor(c);
    at.push_back(at.back() + 1);  // it still encloses the surface
  }
  const VisitLattice visits(mesh, std::move(*lattice));
  int twice = 0;
  eachPoint(visits.lattice(), [&](const LatticeIndex& index, const Point3&) {
    twice += visits.winding(index) == 2 ? 1 : 0;
  });
  EXPECT_EQ(twice, 64);
}

TEST(VisitLattice, FindsACrossingOnEveryEdgeWithOneEndInside) {
  const TriangleMesh mesh = fixtures::pebble(3, 300);
  const VisitLattice visits = latticeOf(mesh, 0.37);
  const WindingNumber winding(mesh);
  for (int axis = 0; axis < 3; ++axis) {
    std::size_t edges = 0;
    eachPoint(visits.lattice(), [&](const LatticeIndex& index, const Point3&) {
      LatticeIndex next = index;
      if (++next[axis] < visits.lattice().at[axis].size()) {
        edges += visits.isInside(index) != visits.isInside(next) ? 1 : 0;
      }
    });
    EXPECT_EQ(visits.crossings(axis).size(), edges);
    for (const LatticeCrossing& crossing : visits.crossings(axis)) {
      const LatticeIndex index = indexOf(crossing.key);
      Point3 place;
      for (int k = 0; k < 3; ++k) place[k] = visits.lattice().at[k][index[k]];
      place[axis] += crossing.fraction * 0.37;
      EXPECT_EQ(std::lround(winding.exactAt(place + 1e-6 * crossing.normal)), 0);
      EXPECT_EQ(std::lround(winding.exactAt(place - 1e-6 * crossing.normal)), 1);
    }
  }
}

TEST(VisitLattice, FindsSliversThatLieAcrossTheLines) {
  // Long thin triangles in all directions, whose boxes hold far more lines than they do.
  for (const Point3& along : {Point3(9, 8, 7), Point3(-7, 9, 0.01), Point3(0.02, -0.01, 9)}) {
    TriangleMesh bar = fixtures::pebble(0.4, 60);
    for (Point3& v : bar.vertices) v += along * v.x();
    const VisitLattice visits = latticeOf(bar, 0.21);
    const WindingNumber winding(bar);
    std::mt19937 random(3);
    eachPoint(visits.lattice(), [&](const LatticeIndex& index, const Point3& point) {
      if (random() % 16 != 0 && !visits.isInside(index)) return;
      EXPECT_EQ(visits.winding(index), std::lround(winding.exactAt(point)));
    });
  }
}

TEST(VisitLattice, KeepsItsPlanesOffTheSidesOfTheBounds) {
  for (const double size : {0.1, 0.49, 0.5, 1.0, 1.5, 2.75, 3.0, 17.999}) {
    const model::Bounds3 bounds = {Point3::Constant(-3), Point3::Constant(-3 + size)};
    const auto lattice = SpaceLattice::about(bounds, 1);
    ASSERT_TRUE(lattice);
    EXPECT_LT(lattice->at[0].front(), -3 - 0.24);
    EXPECT_GT(lattice->at[0].back(), -3 + size + 0.24);
    for (const double c : lattice->at[0]) {
      EXPECT_GE(std::abs(c + 3), 0.249);
      EXPECT_GE(std::abs(c + 3 - size), 0.249);
    }
  }
}

TEST(VisitLattice, RefusesSpacingsThatDoNotFit) {
  const model::Bounds3 bounds = {Point3::Constant(1e6), Point3::Constant(1e6 + 1)};
  const auto tooMany = SpaceLattice::about(bounds, 1e-7);
  ASSERT_FALSE(tooMany);
  EXPECT_EQ(tooMany.error().text(),
            "with a voxel size of 1e-07 there are 1e+07 voxels along an axis; at most 1048576 are "
            "possible");
  const model::Bounds3 far = {Point3::Constant(1e12), Point3::Constant(1e12 + 1)};
  const auto tooFar = SpaceLattice::about(far, 0.1);
  ASSERT_FALSE(tooFar);
  EXPECT_EQ(tooFar.error().text(),
            "a voxel size of 0.1 is too small for coordinates of 1e+12, which are rounded to "
            "multiples of 0.000122");
}

}  // namespace
}  // namespace t4d::measure
