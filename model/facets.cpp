#include "model/facets.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "model/parallel.h"

namespace t4d::model {
namespace {

/// One facet of one cell, without its smallest vertex, which is the index of its bucket.
struct CellFacet {
  std::uint64_t others;  // the middle vertex in the upper half, the largest in the lower
  std::uint32_t cell;
  bool even;
};

// Cells whose facets are looked at, or not, together.
constexpr std::size_t kRunCells = 4096;
// Facets of a part, which fit in a cache.
constexpr std::uint64_t kPartFacets = std::uint64_t{1} << 18;
// Cells that do not follow each other would be looked at for every part.
constexpr std::size_t kMostLooks = 3;

void append(std::vector<Facet>& facets, const std::vector<Facet>& more) {
  facets.insert(facets.end(), more.begin(), more.end());
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

FacetParts::FacetParts(const Connectivity& connectivity)
    : connectivity_(connectivity), facets_(connectivity.vertexCount) {
  const std::vector<Cell>& cells = connectivity.cells;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i % kRunCells == 0) runs_.push_back({connectivity.vertexCount, 0});
    // Three facets have the smallest corner, one has the next.
    const auto& [a, b, c, d] = cells[i];
    const auto [low1, high1] = std::minmax(a, b);
    const auto [low2, high2] = std::minmax(c, d);
    const std::uint32_t lowest = std::min(low1, low2);
    const std::uint32_t next = std::min({std::max(low1, low2), high1, high2});
    facets_[lowest] += 3;
    ++facets_[next];
    runs_.back().lowest = std::min(runs_.back().lowest, lowest);
    runs_.back().highest = std::max(runs_.back().highest, next);
  }
  for (std::uint64_t most = kPartFacets;; most *= 2) {
    begin_ = {0};
    std::uint64_t facets = 0;
    for (std::uint32_t low = 0; low < connectivity.vertexCount; ++low) {
      if (facets >= most) {
        begin_.push_back(low);
        facets = 0;
      }
      facets += facets_[low];
    }
    begin_.push_back(connectivity.vertexCount);
    std::size_t looks = 0;
    const auto partOf = [&](std::uint32_t low) { return std::ranges::upper_bound(begin_, low); };
    for (const Run& run : runs_) {
      looks += static_cast<std::size_t>(partOf(run.highest) - partOf(run.lowest)) + 1;
    }
    if (size() == 1 || looks <= kMostLooks * runs_.size()) return;
  }
}

FacetTopology FacetParts::topology(std::size_t part) const {
  const std::uint32_t lowBegin = begin_[part];
  const std::uint32_t lowEnd = begin_[part + 1];
  // A counting sort by the smallest vertex, then a small sort in each bucket.
  std::vector<std::size_t> ends(std::size_t{lowEnd} - lowBegin + 1, 0);
  for (std::uint32_t low = lowBegin; low < lowEnd; ++low) {
    ends[low - lowBegin + 1] = ends[low - lowBegin] + facets_[low];
  }
  std::vector<CellFacet> sorted(ends.back());
  // Where the next facet goes, and in the end where the bucket ends.
  ends.pop_back();
  for (std::size_t run = 0; run < runs_.size(); ++run) {
    if (runs_[run].highest < lowBegin || runs_[run].lowest >= lowEnd) continue;
    const std::size_t end = std::min((run + 1) * kRunCells, connectivity_.cells.size());
    for (std::size_t i = run * kRunCells; i < end; ++i) {
      for (int corner = 0; corner < 4; ++corner) {
        const auto [vertices, even] = facetOpposite(connectivity_.cells[i], corner);
        const std::uint32_t bucket = vertices[0] - lowBegin;  // large if below
        if (bucket >= ends.size()) continue;
        sorted[ends[bucket]++] = {std::uint64_t{vertices[1]} << 32 | vertices[2],
                                  static_cast<std::uint32_t>(i), even};
      }
    }
  }

  FacetTopology topology;
  const std::uint32_t firstUpper = connectivity_.firstUpper();
  auto at = sorted.begin();
  for (std::uint32_t low = lowBegin; low < lowEnd; ++low) {
    const auto bucketEnd = sorted.begin() + static_cast<std::ptrdiff_t>(ends[low - lowBegin]);
    std::sort(at, bucketEnd, [](const CellFacet& a, const CellFacet& b) {
      return a.others != b.others ? a.others < b.others : a.cell < b.cell;
    });
    while (at != bucketEnd) {
      const std::uint64_t others = at->others;
      Facet facet{
          {low, static_cast<std::uint32_t>(others >> 32), static_cast<std::uint32_t>(others)},
          0,
          0,
          at->cell};
      for (; at != bucketEnd && at->others == others; ++at) ++(at->even ? facet.even : facet.odd);
      if (facet.vertices[2] < connectivity_.lowerCount) {
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

FacetTopology facetTopology(const Connectivity& connectivity) {
  const FacetParts parts(connectivity);
  FacetTopology topology;
  inOrder<std::shared_ptr<const FacetTopology>>(
      parts.size(),
      [&](std::size_t part) { return std::make_shared<const FacetTopology>(parts.topology(part)); },
      [&](const std::shared_ptr<const FacetTopology>& part) {
        append(topology.unmatched, part->unmatched);
        append(topology.lower, part->lower);
        append(topology.upper, part->upper);
        return true;
      });
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
