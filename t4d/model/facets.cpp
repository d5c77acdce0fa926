#include "t4d/model/facets.h"

#include <algorithm>
#include <utility>

namespace t4d::model {
namespace {

/// One facet of one cell, without its smallest vertex, which is the index of its bucket.
struct CellFacet {
  std::uint32_t middle;
  std::uint32_t high;
  std::uint32_t cell;
  bool even;
};

template <class Visit>
void forEachFacet(const std::vector<Cell>& cells, Visit visit) {
  for (std::uint32_t index = 0; index < cells.size(); ++index) {
    for (int corner = 0; corner < 4; ++corner) {
      const auto [vertices, even] = facetOpposite(cells[index], corner);
      visit(vertices[0], CellFacet{vertices[1], vertices[2], index, even});
    }
  }
}

}  // namespace

OrientedFacet orientedFacet(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  bool even = true;
  const auto order = [&even](std::uint32_t& x, std::uint32_t& y) {
    if (x > y) {
      std::swap(x, y);
      even = !even;
    }
  };
  order(a, b);
  order(b, c);
  order(a, b);
  return {{a, b, c}, even};
}

OrientedFacet facetOpposite(const Cell& cell, int corner) {
  // The other corners in order, with the sign (-1)^corner.
  OrientedFacet facet = orientedFacet(cell[corner == 0 ? 1 : 0], cell[corner <= 1 ? 2 : 1],
                                      cell[corner <= 2 ? 3 : 2]);
  if (corner % 2 != 0) facet.even = !facet.even;
  return facet;
}

FacetTopology facetTopology(const Connectivity& connectivity) {
  // A counting sort by the smallest vertex, then a small sort in each bucket.
  std::vector<std::size_t> begin(std::size_t{connectivity.vertexCount} + 1, 0);
  forEachFacet(connectivity.cells, [&](std::uint32_t low, const CellFacet&) { ++begin[low + 1]; });
  for (std::size_t i = 1; i < begin.size(); ++i) begin[i] += begin[i - 1];
  std::vector<CellFacet> sorted(4 * connectivity.cells.size());
  std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
  forEachFacet(connectivity.cells,
               [&](std::uint32_t low, const CellFacet& facet) { sorted[next[low]++] = facet; });

  FacetTopology topology;
  const std::uint32_t firstUpper = connectivity.firstUpper();
  for (std::uint32_t low = 0; low < connectivity.vertexCount; ++low) {
    const auto bucketBegin = sorted.begin() + static_cast<std::ptrdiff_t>(begin[low]);
    const auto bucketEnd = sorted.begin() + static_cast<std::ptrdiff_t>(begin[low + 1]);
    std::sort(bucketBegin, bucketEnd, [](const CellFacet& a, const CellFacet& b) {
      return std::tie(a.middle, a.high, a.cell) < std::tie(b.middle, b.high, b.cell);
    });
    for (auto at = bucketBegin; at != bucketEnd;) {
      Facet facet{{low, at->middle, at->high}, 0, 0, at->cell};
      for (; at != bucketEnd && at->middle == facet.vertices[1] && at->high == facet.vertices[2];
           ++at) {
        ++(at->even ? facet.even : facet.odd);
      }
      if (facet.vertices[2] < connectivity.lowerCount) {
        topology.lower.push_back(facet);
      } else if (low >= firstUpper) {
        for (std::uint32_t& vertex : facet.vertices) vertex -= firstUpper;
        topology.upper.push_back(facet);
      } else if (!facet.isMatched()) {
        topology.unmatched.push_back(facet);
      }
    }
  }
  return topology;
}

std::vector<Facet> unmatchedAtSeam(const std::vector<Facet>& before,
                                   const std::vector<Facet>& after) {
  std::vector<Facet> unmatched;
  auto a = before.begin();
  auto b = after.begin();
  while (a != before.end() || b != after.end()) {
    Facet facet;
    if (b == after.end() || (a != before.end() && a->vertices < b->vertices)) {
      facet = *a++;
    } else if (a == before.end() || b->vertices < a->vertices) {
      facet = *b++;
    } else {
      facet = *a++;
      facet.even += b->even;
      facet.odd += b->odd;
      ++b;
    }
    if (!facet.isMatched()) unmatched.push_back(facet);
  }
  return unmatched;
}

}  // namespace t4d::model
