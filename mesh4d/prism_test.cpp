#include "mesh4d/prism.h"

#include <random>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "model/facets.h"
#include "t4d/slice.h"

namespace t4d::mesh4d {
namespace {

constexpr PrismSplit kSplits[] = {PrismSplit::Fourteen, PrismSplit::Three};

TEST(Prism, HasTheCountsOfThePaper) {
  for (const fixtures::NamedSolid& solid : fixtures::allSolids({})) {
    SCOPED_TRACE(solid.name);
    const std::size_t v = solid.mesh.vertices.size();
    const std::size_t f = solid.mesh.triangles.size();
    const std::size_t e = 3 * f / 2;
    const auto fourteen = stepConnectivity(solid.mesh, PrismSplit::Fourteen);
    EXPECT_EQ(fourteen->vertexCount, 2 * v + e + f);
    EXPECT_EQ(fourteen->means.size(), e + f);
    EXPECT_EQ(fourteen->cells.size(), 14 * f);
    const auto three = stepConnectivity(solid.mesh, PrismSplit::Three);
    EXPECT_EQ(three->vertexCount, 2 * v);
    EXPECT_EQ(three->means.size(), 0U);
    EXPECT_EQ(three->cells.size(), 3 * f);
    for (const auto& step : {fourteen, three}) {
      EXPECT_TRUE(checkConnectivity(*step));
      EXPECT_EQ(step->lowerCount, v);
      EXPECT_EQ(step->upperCount, v);
    }
  }
}

TEST(Prism, IsClosedButForTheSolidsTrianglesInBothLayers) {
  for (const fixtures::NamedSolid& solid : fixtures::allSolids({})) {
    for (const PrismSplit split : kSplits) {
      SCOPED_TRACE(solid.name);
      const auto topology = facetTopology(*stepConnectivity(solid.mesh, split));
      EXPECT_TRUE(topology.unmatched.empty());
      for (const auto* facets : {&topology.lower, &topology.upper}) {
        ASSERT_EQ(facets->size(), solid.mesh.triangles.size());
        for (const model::Facet& facet : *facets) EXPECT_EQ(facet.even + facet.odd, 1U);
      }
      // Facets open below are open above, with opposite orientation.
      EXPECT_TRUE(unmatchedAtSeam(topology.upper, topology.lower).empty());
    }
  }
}

/// One step of unit time from a solid to arbitrary new positions of its vertices.
model::Slab stepBetween(const model::TriangleMesh& from, const std::vector<model::Point3>& to,
                        PrismSplit split) {
  model::Slab slab;
  slab.timeEnd = 1;
  slab.connectivity = stepConnectivity(from, split);
  slab.vertices.resize(slab.connectivity->vertexCount);
  for (std::size_t i = 0; i < to.size(); ++i) {
    slab.vertices[i] << from.vertices[i], 0;
    slab.vertices[slab.connectivity->firstUpper() + i] << to[i], 1;
  }
  setMeans(*slab.connectivity, slab.vertices);
  return slab;
}

TEST(Prism, SliceHasTheVolumeOfTheInterpolatedMeshHoweverVerticesMove) {
  std::mt19937 random(13);
  std::uniform_real_distribution<double> number(-1, 1);
  for (const model::TriangleMesh& solid :
       {fixtures::paperCube(2), fixtures::torus(2, 1, 8, 6), fixtures::hollowCube(4, 2)}) {
    model::TriangleMesh other = solid;
    for (model::Point3& vertex : other.vertices) {
      vertex = {number(random), number(random), number(random)};
    }
    model::Mesh mesh;
    ASSERT_TRUE(mesh.put(stepBetween(solid, other.vertices, PrismSplit::Fourteen)));
    for (const double s : {0.0, 0.1, 0.25, 0.5, 0.618, 0.875}) {
      model::TriangleMesh between = solid;
      for (std::size_t i = 0; i < between.vertices.size(); ++i) {
        between.vertices[i] = (1 - s) * solid.vertices[i] + s * other.vertices[i];
      }
      const auto slice = slice::sliceAtTime(mesh, s);
      ASSERT_TRUE(slice) << slice.error().text();
      EXPECT_TRUE(isClosed(slice->mesh));
      EXPECT_NEAR(signedVolume(slice->mesh), signedVolume(between), 1e-12 * signedVolume(solid));
    }
  }
}

TEST(Prism, SliceOfATranslationIsTheSolidInBothDivisions) {
  const model::TriangleMesh solid = fixtures::icosphere(3, 1);
  std::vector<model::Point3> moved = solid.vertices;
  for (model::Point3& vertex : moved) vertex += model::Point3(1, -2, 0.5);
  for (const PrismSplit split : kSplits) {
    model::Mesh mesh;
    ASSERT_TRUE(mesh.put(stepBetween(solid, moved, split)));
    for (const double s : {0.0, 0.3, 0.5, 0.9}) {
      const auto slice = slice::sliceAtTime(mesh, s);
      EXPECT_TRUE(isClosed(slice->mesh));
      EXPECT_NEAR(signedVolume(slice->mesh), signedVolume(solid), 1e-12 * signedVolume(solid));
      EXPECT_NEAR(surfaceArea(slice->mesh), surfaceArea(solid), 1e-12 * surfaceArea(solid));
    }
  }
}

}  // namespace
}  // namespace t4d::mesh4d
