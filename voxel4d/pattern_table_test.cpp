#include "voxel4d/pattern_table.h"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <set>
#include <vector>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "model/facets.h"
#include "voxel4d/pattern_patches.h"

namespace t4d::voxel4d {
namespace {

/// Facets of one pattern's cells: how often each occurs, with its sign.
struct Count {
  int even = 0;
  int odd = 0;
};
using Facets = std::map<std::array<std::uint32_t, 3>, Count>;

Facets facetsOf(unsigned pattern) {
  Facets facets;
  for (const auto& [a, b, c, d] : PatternTable::tetrahedra(pattern)) {
    const model::Cell cell = {a, b, c, d};
    for (int corner = 0; corner < 4; ++corner) {
      const model::OrientedFacet facet = model::facetOpposite(cell, corner);
      ++(facet.even ? facets[facet.vertices].even : facets[facet.vertices].odd);
    }
  }
  return facets;
}

/// The sides (axis, 0 or 1) of the hypercube that an edge lies on.
std::set<std::pair<int, int>> sidesOf(int edge) {
  std::set<std::pair<int, int>> sides;
  for (int axis = 0; axis < 4; ++axis) {
    if (axis != edgeAxis(edge)) sides.insert({axis, edgeCorner(edge) >> axis & 1});
  }
  return sides;
}

/// The signs of a side's 8 corners, in the order of the corners.
unsigned signsOf(unsigned pattern, int axis, int value) {
  unsigned signs = 0;
  int at = 0;
  for (int corner = 0; corner < kCorners; ++corner) {
    if ((corner >> axis & 1) == value) signs |= (pattern >> corner & 1U) << at++;
  }
  return signs;
}

/// An edge of the side of value 1 as seen from the neighbour, where it is on the side of value 0.
int movedToZero(int edge, int axis) {
  const int corner = edgeCorner(edge) & ~(1 << axis);
  for (int other = 0; other < kEdges; ++other) {
    if (edgeAxis(other) == edgeAxis(edge) && edgeCorner(other) == corner) return other;
  }
  return -1;
}

TEST(PatternTable, EdgesJoinNeighbours) {
  std::set<std::pair<int, int>> seen;
  for (int edge = 0; edge < kEdges; ++edge) {
    EXPECT_EQ(edgeCorner(edge) >> edgeAxis(edge) & 1, 0);
    EXPECT_TRUE(seen.insert({edgeCorner(edge), edgeAxis(edge)}).second);
  }
}

TEST(PatternTable, IsThatOfThe402Classes) {
  const PatternPatches patches = computePatternPatches();
  EXPECT_EQ(patches.classCount, 402);
  for (unsigned pattern = 0; pattern < kPatterns; ++pattern) {
    const std::span all(patches.tetrahedra);
    ASSERT_TRUE(std::ranges::equal(
        PatternTable::tetrahedra(pattern),
        all.subspan(patches.first[pattern], patches.first[pattern + 1] - patches.first[pattern])));
  }
}

/// The conditions under which hypercubes fit together, for all 65,536 patterns: an interior facet
/// has two cells on opposite sides; every other facet lies on exactly one side of the hypercube;
/// and the unmatched facets on a side depend on that side's signs alone, mirrored for the neighbour
/// that shares it.
TEST(PatternTable, EveryPatternFitsItsNeighbours) {
  using Left = std::vector<std::pair<std::array<std::uint32_t, 3>, bool>>;
  std::map<std::pair<int, unsigned>, Left> onSide;  // (axis, signs) as on the side of value 0
  for (unsigned pattern = 0; pattern < kPatterns; ++pattern) {
    std::map<std::pair<int, int>, Left> left;
    for (int axis = 0; axis < 4; ++axis) left[{axis, 0}], left[{axis, 1}];
    for (const auto& [vertices, count] : facetsOf(pattern)) {
      if (count.even == 1 && count.odd == 1) continue;
      ASSERT_EQ(count.even + count.odd, 1) << pattern;
      std::set<std::pair<int, int>> common = sidesOf(static_cast<int>(vertices[0]));
      for (const std::uint32_t vertex : {vertices[1], vertices[2]}) {
        std::set<std::pair<int, int>> both;
        const auto sides = sidesOf(static_cast<int>(vertex));
        std::set_intersection(common.begin(), common.end(), sides.begin(), sides.end(),
                              std::inserter(both, both.begin()));
        common = both;
      }
      ASSERT_EQ(common.size(), 1U) << pattern;
      const auto [axis, value] = *common.begin();
      std::array<std::uint32_t, 3> moved = vertices;
      if (value == 1) {
        for (auto& vertex : moved) vertex = movedToZero(static_cast<int>(vertex), axis);
      }
      const model::OrientedFacet facet = model::orientedFacet(moved[0], moved[1], moved[2]);
      // Seen from the neighbour, the facet has the opposite orientation.
      const bool even = (count.even == 1) == facet.even;
      left[{axis, value}].emplace_back(facet.vertices, value == 0 ? even : !even);
    }
    for (auto& [side, facets] : left) {
      std::sort(facets.begin(), facets.end());
      const auto key = std::pair(side.first, signsOf(pattern, side.first, side.second));
      const auto [known, isNew] = onSide.try_emplace(key, facets);
      ASSERT_EQ(known->second, facets) << pattern;
    }
  }
}

/// The midpoint of an edge in doubled coordinates.
Eigen::Vector4i middleOf(int edge) {
  Eigen::Vector4i middle;
  for (int axis = 0; axis < 4; ++axis) middle[axis] = 2 * (edgeCorner(edge) >> axis & 1);
  middle[edgeAxis(edge)] = 1;
  return middle;
}

/// The hyperplane of a tetrahedron: its normal, and the normal times any of its points.
std::array<int, 5> hyperplaneOf(const PatternTable::Tetrahedron& cell) {
  Eigen::Matrix<int, 4, 3> sides;
  for (int k = 0; k < 3; ++k) sides.col(k) = middleOf(cell[k + 1]) - middleOf(cell[0]);
  std::array<int, 5> plane{};
  int divisor = 0;
  for (int axis = 0; axis < 4; ++axis) {
    Eigen::Matrix3i minor;
    for (int row = 0, at = 0; row < 4; ++row) {
      if (row != axis) minor.row(at++) = sides.row(row);
    }
    plane[axis] = (axis % 2 == 0 ? 1 : -1) * minor.determinant();
    divisor = std::gcd(divisor, plane[axis]);
  }
  for (int axis = 0; axis < 4; ++axis) {
    plane[axis] /= divisor;
    plane[4] += plane[axis] * middleOf(cell[0])[axis];
  }
  return plane;
}

TEST(PatternTable, PolytopesArePulledFromTheirSmallestVertex) {
  // "Smallest" by t, then z, y, x.
  const auto isLess = [](int a, int b) {
    const Eigen::Vector4i p = middleOf(a).reverse();
    const Eigen::Vector4i q = middleOf(b).reverse();
    return std::ranges::lexicographical_compare(p, q);
  };
  for (unsigned pattern = 0; pattern < kPatterns; pattern += 97) {
    std::map<std::array<int, 5>, std::vector<PatternTable::Tetrahedron>> polytopes;
    for (const auto& cell : PatternTable::tetrahedra(pattern)) {
      polytopes[hyperplaneOf(cell)].push_back(cell);
    }
    for (const auto& [plane, cells] : polytopes) {
      int smallest = cells[0][0];
      for (const auto& cell : cells) {
        for (const int vertex : cell) smallest = std::min(smallest, vertex, isLess);
      }
      for (const auto& cell : cells) {
        EXPECT_NE(std::ranges::find(cell, smallest), cell.end()) << pattern;
      }
    }
  }
}

TEST(PatternTable, EveryVertexIsASignChange) {
  for (unsigned pattern = 0; pattern < kPatterns; ++pattern) {
    unsigned used = 0;
    for (const auto& cell : PatternTable::tetrahedra(pattern)) {
      for (const auto edge : cell) used |= 1U << edge;
    }
    for (int edge = 0; edge < kEdges; ++edge) {
      const int corner = edgeCorner(edge);
      const int other = corner | 1 << edgeAxis(edge);
      const bool changes = (pattern >> corner & 1U) != (pattern >> other & 1U);
      ASSERT_EQ((used >> edge & 1U) != 0, changes) << pattern << " edge " << edge;
    }
  }
}

}  // namespace
}  // namespace t4d::voxel4d
