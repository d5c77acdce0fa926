#include "edit/cell_complex.h"

#include <array>
#include <cmath>
#include <cstdlib>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "fixtures/polytopes.h"
#include "fixtures/solids.h"
#include "measure/vertex_links.h"
#include "model/facets.h"
#include "t4d/mesh.h"
#include "t4d/sweep.h"
#include "t4d/weave.h"
#include "voxel4d/sampled_frames.h"

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

/// A sphere of four triangles times a circle of three edges: each prism is three tetrahedra.
std::vector<Cell> thinnestRing() {
  const auto at = [](std::uint32_t corner, std::uint32_t step) { return corner + 4 * (step % 3); };
  std::vector<Cell> cells;
  for (std::uint32_t without = 0; without < 4; ++without) {
    std::vector<std::uint32_t> triangle;
    for (std::uint32_t corner = 0; corner < 4; ++corner) {
      if (corner != without) triangle.push_back(corner);
    }
    const auto [i, j, k] = std::array{triangle[0], triangle[1], triangle[2]};
    for (std::uint32_t s = 0; s < 3; ++s) {
      cells.push_back({at(i, s), at(j, s), at(k, s), at(k, s + 1)});
      cells.push_back({at(i, s), at(j, s), at(j, s + 1), at(k, s + 1)});
      cells.push_back({at(i, s), at(i, s + 1), at(j, s + 1), at(k, s + 1)});
    }
  }
  return cells;
}

TEST(CellComplex, ARingIsNeitherCutNorPinched) {
  // An edge along the ring would close it at a vertex; one across, its sphere.
  const CellComplex complex(thinnestRing(), 12);
  for (std::uint32_t a = 0; a < 12; ++a) {
    for (std::uint32_t b = 0; b < 12; ++b) {
      EXPECT_FALSE(a != b && complex.canCollapse(a, b)) << a << " " << b;
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

CellComplex complexOf(const model::Source& mesh) {
  const auto flat = model::flatten(mesh);
  EXPECT_TRUE(flat);
  std::vector<Cell> cells;
  for (Eigen::Index i = 0; i < flat->cells.rows(); ++i) {
    const auto row = flat->cells.row(i);
    cells.push_back({row[0], row[1], row[2], row[3]});
  }
  return {cells, static_cast<std::uint32_t>(flat->vertices.rows())};
}

CellComplex wovenNoise(std::mt19937& random) {
  const auto noise = [seed = random()](const model::Point3& p, double t) {
    const Eigen::Vector4d at(p[0], p[1], p[2], t);
    const auto cell =
        static_cast<std::uint32_t>(std::lround(at.dot(Eigen::Vector4d(1, 8, 64, 512))));
    std::mt19937 ofCell(seed ^ cell);
    ofCell.discard(4);
    return ofCell() % 2 == 0 ? 1.0 : -1.0;
  };
  model::Bounds3 box;
  box.add({0, 0, 0});
  box.add({2, 2, 2});
  const std::vector<double> times = {0, 1, 2};
  const auto frames = voxel4d::sampledFrames(noise, {}, box, times, {.slope = 1e6});
  model::Mesh mesh;
  EXPECT_TRUE(voxel4d::weave(*frames, {}, mesh));
  return complexOf(mesh);
}

CellComplex randomSweep(std::mt19937& random) {
  std::uniform_real_distribution<double> any(-1, 1);
  model::ScrewRun run;
  run.duration = 1;
  run.screw.axisDirection = Eigen::Vector3d(any(random), any(random), 1).normalized();
  run.screw.angleDegrees = 90 * any(random);
  run.screw.translation = {any(random), any(random), any(random)};
  model::Mesh mesh;
  EXPECT_TRUE(mesh4d::sweep(fixtures::icosphere(1, 0), *model::chainScrews(0, {&run, 1}),
                            {mesh4d::StepsPerSegment{2}, mesh4d::CapMethod::Cone}, mesh));
  return complexOf(mesh);
}

CellComplex polytope(std::mt19937& /*random*/) {
  const fixtures::Polytope polytope = fixtures::cell600();
  return {fixtures::tetrahedra(polytope), static_cast<std::uint32_t>(polytope.vertices.size())};
}

TEST(CellComplex, RandomCollapsesKeepThe3Manifold) {
  const std::size_t wanted = std::getenv("T4D_ALL") != nullptr ? 20'000 : 2'000;
  std::mt19937 random(30);
  std::size_t collapses = 0;
  for (std::size_t which = 0; collapses < wanted; ++which) {
    constexpr std::array kMakers = {polytope, wovenNoise, randomSweep};
    CellComplex complex = kMakers[which % kMakers.size()](random);
    const std::uint32_t before = complex.liveCells();
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
    EXPECT_LT(complex.liveCells(), before * 7 / 10);
  }
}

}  // namespace
}  // namespace t4d::edit
