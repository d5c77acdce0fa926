#include <bit>
#include <cstring>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "t4d/mesh.h"

namespace t4d::model {
namespace {

/// One tetrahedron on a lower layer of three vertices, with a mean, an upper vertex above.
Connectivity small() {
  Connectivity connectivity;
  connectivity.vertexCount = 5;
  connectivity.lowerCount = 3;
  connectivity.upperCount = 1;
  connectivity.cells = {{0, 1, 2, 4}, {0, 1, 2, 3}};
  connectivity.means.add(std::vector<std::uint32_t>{0, 1, 2, 4});
  return connectivity;
}

Slab smallSlab() {
  Slab slab;
  slab.timeEnd = 1;
  slab.connectivity = std::make_shared<Connectivity>(small());
  slab.vertices = {{0, 0, 0, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 0, 0}, {0, 0, 4, 1}};
  setMeans(*slab.connectivity, slab.vertices);
  return slab;
}

TEST(Slab, MeanIsTheSumInListedOrderDividedByTheNumber) {
  EXPECT_EQ(smallSlab().vertices[3], Point4(0.25, 0.25, 1, 0.25));
}

TEST(Slab, AttributesOfMeansAreMeansOrThoseOfTheFirstSource) {
  const Connectivity connectivity = small();  // vertex 3 is the mean of 0, 1, 2, 4
  const auto meanOf = [&]<class T>(const std::vector<T>& values) {
    Attribute attribute = makeAttribute("a", Domain::Vertex, values);
    setMeans(connectivity, attribute);
    T mean;
    std::memcpy(&mean, attribute.row(3), sizeof mean);
    return mean;
  };
  EXPECT_EQ(meanOf(std::vector<double>{1, 2, 3, 0, 5}), 2.75);
  EXPECT_EQ(meanOf(std::vector<std::int16_t>{-7, 2, 3, 0, 5}), -7);
  // The sum is that of double precision, and only the mean is rounded.
  EXPECT_EQ(meanOf(std::vector<float>{1, 0x1p-24F, 0x1p-24F, 0, 0}), 0.25F + 0x1p-25F);
  const float infinity = std::numeric_limits<float>::infinity();
  const float none = meanOf(std::vector<float>{infinity, -infinity, 0, 0, 0});
  EXPECT_EQ(std::bit_cast<std::uint32_t>(none), 0x7FC00000U);
  const double payload = std::bit_cast<double>(std::uint64_t{0xFFF8000000000123});
  EXPECT_EQ(std::bit_cast<std::uint64_t>(meanOf(std::vector<double>{1, payload, 0, 0, 0})),
            0x7FF8000000000000U);
}

TEST(Slab, SoundOneIsAccepted) {
  EXPECT_TRUE(checkConnectivity(small()));
  EXPECT_TRUE(checkSlab(smallSlab()));
}

TEST(Slab, EveryUnsoundConnectivityIsNamed) {
  struct Case {
    std::string expected;
    std::function<void(Connectivity&)> spoil;
  };
  const Case cases[] = {
      {"exceed", [](Connectivity& c) { c.lowerCount = 4; }},
      {"exceed", [](Connectivity& c) { c.lowerCount = c.upperCount = ~0U; }},
      {"has the vertex 5, of 5", [](Connectivity& c) { c.cells[1][2] = 5; }},
      {"twice", [](Connectivity& c) { c.cells[1][2] = 0; }},
      {"is a mean itself", [](Connectivity& c) { c.means.sources[0] = 3; }},
      {"not one of", [](Connectivity& c) { c.means.sources[0] = 9; }},
      {"do not span", [](Connectivity& c) { c.means.offsets[1] = 3; }},
      {"of no vertex",
       [](Connectivity& c) {
         c.means = {{0, 0}, {}};
       }},
      {"but no means", [](Connectivity& c) { c.means.offsets.clear(); }},
      {"not per cell",
       [](Connectivity& c) {
         c.cellAttributes = {makeAttribute<float>("a", Domain::Vertex, {1, 2, 3, 4, 5})};
       }},
      {"rows",
       [](Connectivity& c) { c.cellAttributes = {makeAttribute<float>("a", Domain::Cell, {1})}; }},
  };
  for (const Case& one : cases) {
    Connectivity connectivity = small();
    one.spoil(connectivity);
    const auto checked = checkConnectivity(connectivity);
    ASSERT_FALSE(checked) << one.expected;
    EXPECT_NE(checked.error().message.find(one.expected), std::string::npos)
        << checked.error().message;
  }
}

TEST(Slab, EveryUnsoundSlabIsNamed) {
  struct Case {
    std::string expected;
    std::function<void(Slab&)> spoil;
  };
  const Case cases[] = {
      {"4 vertices where", [](Slab& s) { s.vertices.pop_back(); }},
      {"lower layer", [](Slab& s) { s.vertices[1][3] = 0.5; }},
      {"upper layer", [](Slab& s) { s.vertices[4][3] = 0.5; }},
      {"outside", [](Slab& s) { s.vertices[3][3] = 2; }},
      {"nan", [](Slab& s) { s.vertices[3][0] = std::numeric_limits<double>::quiet_NaN(); }},
      {"lasts", [](Slab& s) { s.timeBegin = 2; }},
      {"attribute",
       [](Slab& s) {
         s.attributes = {makeAttribute<float>("a", Domain::Vertex, {1, 2, 3})};
       }},
  };
  for (const Case& one : cases) {
    Slab slab = smallSlab();
    one.spoil(slab);
    const auto checked = checkSlab(slab);
    ASSERT_FALSE(checked) << one.expected;
    EXPECT_NE(checked.error().message.find(one.expected), std::string::npos)
        << checked.error().message;
  }
}

}  // namespace
}  // namespace t4d::model
