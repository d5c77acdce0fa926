#include <array>
#include <memory>

#include <gtest/gtest.h>

#include "t4d/mesh.h"

namespace t4d::model {
namespace {

/// A mesh of one slab without cells.
Mesh meshOver(double begin, double end) {
  Slab slab;
  slab.timeBegin = begin;
  slab.timeEnd = end;
  slab.connectivity = std::make_shared<Connectivity>();
  Mesh mesh;
  EXPECT_TRUE(mesh.put(slab));
  return mesh;
}

TEST(TimeSpanOf, BodiesIsThatOfThoseThatAreThere) {
  const std::array<Mesh, 3> meshes = {Mesh(), meshOver(5, 7), meshOver(6, 9)};
  std::array<Body, 3> bodies;
  for (std::size_t i = 0; i < 3; ++i) bodies[i].source = &meshes[i];
  EXPECT_EQ(timeSpanOf(bodies).begin, 5);
  EXPECT_EQ(timeSpanOf(bodies).end, 9);
  EXPECT_EQ(timeSpanOf(std::span(bodies).first(1)).begin, 0);
  EXPECT_EQ(timeSpanOf(std::span(bodies).first(1)).end, 0);
}

}  // namespace
}  // namespace t4d::model
