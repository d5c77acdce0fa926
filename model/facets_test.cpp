#include "model/facets.h"

#include <algorithm>
#include <map>
#include <random>

#include <gtest/gtest.h>

namespace t4d::model {
namespace {

/// Cells of random vertices; of such in a short range that moves on, if `inOrder`.
Connectivity randomCells(std::uint32_t vertices, std::size_t count, bool inOrder) {
  std::mt19937 random(7);
  Connectivity connectivity;
  connectivity.vertexCount = vertices;
  connectivity.lowerCount = connectivity.upperCount = vertices / 3;
  const std::uint32_t range = inOrder ? 40 : vertices;
  for (std::size_t i = 0; i < count; ++i) {
    const auto first = static_cast<std::uint32_t>(i * (vertices - range) / count);
    Cell cell{};
    do {
      for (std::uint32_t& corner : cell) corner = first + random() % range;
      std::ranges::sort(cell);
    } while (std::ranges::adjacent_find(cell) != cell.end());
    std::ranges::shuffle(cell, random);
    connectivity.cells.push_back(cell);
  }
  return connectivity;
}

/// Compares the facets with those of each cell, one after the other.
void expectAll(const Connectivity& connectivity) {
  std::map<std::array<std::uint32_t, 3>, Facet> expected;
  for (std::uint32_t i = 0; i < connectivity.cells.size(); ++i) {
    for (int corner = 0; corner < 4; ++corner) {
      const auto [vertices, even] = facetOpposite(connectivity.cells[i], corner);
      Facet& facet = expected.try_emplace(vertices, Facet{vertices, 0, 0, i}).first->second;
      ++(even ? facet.even : facet.odd);
    }
  }
  const FacetTopology found = facetTopology(connectivity);
  auto lower = found.lower.begin();
  auto upper = found.upper.begin();
  auto unmatched = found.unmatched.begin();
  for (auto [vertices, facet] : expected) {
    const bool isLower = vertices[2] < connectivity.lowerCount;
    const bool isUpper = vertices[0] >= connectivity.firstUpper();
    if (!isLower && !isUpper && facet.isMatched()) continue;
    if (isUpper) {
      for (std::uint32_t& vertex : facet.vertices) vertex -= connectivity.firstUpper();
    }
    const Facet& other = isLower ? *lower++ : isUpper ? *upper++ : *unmatched++;
    ASSERT_EQ(other.vertices, facet.vertices);
    ASSERT_EQ(other.even, facet.even);
    ASSERT_EQ(other.odd, facet.odd);
    ASSERT_EQ(other.cell, facet.cell);
  }
  EXPECT_EQ(lower, found.lower.end());
  EXPECT_EQ(upper, found.upper.end());
  EXPECT_EQ(unmatched, found.unmatched.end());
}

TEST(Facets, OfManyCellsAreFoundInPartsAndCountedOnce) {
  for (const bool inOrder : {false, true}) {
    const Connectivity connectivity = randomCells(inOrder ? 100'000 : 60, 300'000, inOrder);
    EXPECT_EQ(FacetParts(connectivity).size() > 3, inOrder);
    expectAll(connectivity);
  }
}

TEST(Facets, OfCellsThatReachTheFirstVertexOfAPartAreFound) {
  // 2^18 facets make a part, and 4096 cells are looked at together. The last of these share their
  // two smallest vertices, of which the second is where the second part begins.
  Connectivity connectivity;
  connectivity.vertexCount = 100'000;
  connectivity.lowerCount = connectivity.upperCount = 10;
  for (std::uint32_t i = 0; i < 17 * 4096; ++i) {
    const std::uint32_t low = i < 16 * 4096 ? i / 8 : 8190;
    connectivity.cells.push_back({low, low + 1, low + 10 + i % 8, 20'000 + i});
  }
  ASSERT_EQ(FacetParts(connectivity).size(), 2U);
  expectAll(connectivity);
}

}  // namespace
}  // namespace t4d::model
