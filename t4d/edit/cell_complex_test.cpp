#include "t4d/edit/cell_complex.h"

#include <cstdlib>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "t4d/fixtures/polytopes.h"
#include "t4d/measure/vertex_links.h"
#include "t4d/model/facets.h"

namespace t4d::edit {
namespace {

using model::Cell;

/// The boundary of a 4-simplex with these vertices.
std::vector<Cell> simplexBoundary(const std::array<std::uint32_t, 5>& v) {
  return {{v[1], v[2], v[3], v[4]},
          {v[0], v[3], v[2], v[4]},
          {v[0], v[1], v[3], v[4]},
          {v[0], v[2], v[1], v[4]},
          {v[0], v[1], v[2], v[3]}};
}

model::Connectivity connectivityOf(const CellComplex& complex) {
  model::Connectivity connectivity;
  connectivity.vertexCount = complex.vertexCount();
  for (std::uint32_t i = 0; i < complex.cells().size(); ++i) {
    if (!complex.isDead(i)) connectivity.cells.push_back(complex.cells()[i]);
  }
  return connectivity;
}

/// V - E + F - C of the cells.
std::int64_t eulerCharacteristic(const model::Connectivity& connectivity) {
  std::set<std::uint32_t> vertices;
  std::set<std::array<std::uint32_t, 2>> edges;
  for (const Cell& cell : connectivity.cells) {
    for (int i = 0; i < 4; ++i) {
      vertices.insert(cell[i]);
      for (int j = 0; j < i; ++j) {
        edges.insert({std::min(cell[i], cell[j]), std::max(cell[i], cell[j])});
      }
    }
  }
  const auto cells = static_cast<std::int64_t>(connectivity.cells.size());
  return static_cast<std::int64_t>(vertices.size()) - static_cast<std::int64_t>(edges.size()) +
         cells;
}

void expectManifold(const CellComplex& complex) {
  const model::Connectivity connectivity = connectivityOf(complex);
  ASSERT_TRUE(model::facetTopology(connectivity).unmatched.empty());
  ASSERT_TRUE(measure::nonManifoldInteriorVertices(connectivity).empty());
  ASSERT_EQ(eulerCharacteristic(connectivity), 0);
}

TEST(CellComplex, TheSmallestSphereCannotBecomeSmaller) {
  const CellComplex complex(simplexBoundary({0, 1, 2, 3, 4}), 5);
  for (std::uint32_t a = 0; a < 5; ++a) {
    for (std::uint32_t b = 0; b < 5; ++b) {
      EXPECT_FALSE(a != b && complex.canCollapse(a, b));
    }
  }
}

TEST(CellComplex, BodiesThatTouchAtAVertexStayApart) {
  std::vector<Cell> cells = simplexBoundary({0, 1, 2, 3, 4});
  for (const Cell& cell : simplexBoundary({4, 5, 6, 7, 8})) cells.push_back(cell);
  const CellComplex complex(cells, 9);
  EXPECT_FALSE(complex.canCollapse(0, 4));
  EXPECT_FALSE(complex.canCollapse(0, 5));  // no edge
}

TEST(CellComplex, AVertexIntoATetrahedronCanBeTakenOutAgain) {
  // One cell of the smallest sphere divided into four about vertex 5.
  std::vector<Cell> cells = simplexBoundary({0, 1, 2, 3, 4});
  const Cell whole = cells.back();
  cells.pop_back();
  for (int k = 0; k < 4; ++k) {
    cells.push_back(whole);
    cells.back()[k] = 5;
  }
  CellComplex complex(cells, 6);
  ASSERT_TRUE(complex.canCollapse(0, 5));
  // The other way the facets opposite would coincide.
  EXPECT_FALSE(complex.canCollapse(0, 1));
  complex.collapse(0, 5);
  EXPECT_EQ(complex.liveCells(), 5U);
  expectManifold(complex);
}

TEST(CellComplex, RandomCollapsesKeepThe3Sphere) {
  const std::size_t wanted = std::getenv("T4D_ALL") != nullptr ? 100'000 : 2'000;
  std::mt19937 random(30);
  std::size_t collapses = 0;
  while (collapses < wanted) {
    const fixtures::Polytope polytope = fixtures::cell600();
    CellComplex complex(fixtures::tetrahedra(polytope),
                        static_cast<std::uint32_t>(polytope.vertices.size()));
    for (int failures = 0; failures < 200;) {
      const auto a = static_cast<std::uint32_t>(random() % complex.vertexCount());
      if (!complex.isUsed(a)) continue;
      const auto near = complex.neighbours(a);
      const std::uint32_t b = near[random() % near.size()];
      if (!complex.canCollapse(a, b)) {
        ++failures;
        continue;
      }
      complex.collapse(a, b);
      ++collapses;
      expectManifold(complex);
      if (testing::Test::HasFatalFailure()) return;
    }
    EXPECT_LT(complex.liveCells(), 300U);
  }
}

}  // namespace
}  // namespace t4d::edit
