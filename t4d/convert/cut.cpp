#include "t4d/convert/cut.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <unordered_map>

namespace t4d::convert {
namespace {

using model::Cell;
using model::Triangle;

/// The two corners of a cell with a cut point between them: one below and one above.
struct CutEdge {
  std::uint8_t below;
  std::uint8_t above;
};

/// The section of a cell for each pattern of corners above (bit i for corner i): a polygon of 0, 3
/// or 4 cut edges. With an even permutation (i, j, k, l) of the corners it is
///
///     i below:       ij, ik, il          i above:  il, ik, ij
///     i, j below:    ik, il, jl, jk
///
/// which faces outward if the cell does: for i below, moving away from corner i along the three
/// edges keeps det[n, j-i, k-i, l-i] > 0.
struct Section {
  std::uint8_t size = 0;
  std::array<CutEdge, 4> edges{};
};

std::array<Section, 16> makeSections() {
  std::array<Section, 16> sections;
  std::array<std::uint8_t, 4> p = {0, 1, 2, 3};
  do {
    int inversions = 0;
    for (int a = 0; a < 4; ++a) {
      for (int b = a + 1; b < 4; ++b) inversions += p[a] > p[b] ? 1 : 0;
    }
    if (inversions % 2 != 0) continue;
    const auto [i, j, k, l] = p;
    const unsigned one = 1U << i;
    sections[15U ^ one] = {3, {{{i, j}, {i, k}, {i, l}, {}}}};
    sections[one] = {3, {{{l, i}, {k, i}, {j, i}, {}}}};
    sections[1U << k | 1U << l] = {4, {{{i, k}, {i, l}, {j, l}, {j, k}}}};
  } while (std::next_permutation(p.begin(), p.end()));
  return sections;
}

const std::array<Section, 16>& sections() {
  static const std::array<Section, 16> table = makeSections();
  return table;
}

constexpr std::uint32_t kNone = ~0U;

/// The number of each point. Each vertex has a chain of the points on edges to vertices above it,
/// whose entries are close together in memory because the cells are. A chain that would be longer
/// than a few dozen, as at the apex of a cone, goes on in a hash table.
class PointTable {
 public:
  PointTable(std::size_t vertexCount, std::vector<Cut::Point>& points)
      : first_(vertexCount, kNone), points_(points) {}

  /// The number of the point, which is new if it has not been asked for before.
  std::uint32_t numberOf(std::uint32_t below, std::uint32_t above) {
    std::uint32_t* link = &first_[below];
    for (int length = 0; *link != kNone; ++length) {
      if (points_[*link].above == above) return *link;
      if (length == kLongestChain) {
        const auto [found, isNew] =
            others_.try_emplace(std::uint64_t{below} << 32U | above, count());
        if (isNew) add(below, above);
        return found->second;
      }
      link = &next_[*link];
    }
    *link = count();
    add(below, above);
    return count() - 1;
  }

 private:
  std::uint32_t count() const { return static_cast<std::uint32_t>(points_.size()); }
  void add(std::uint32_t below, std::uint32_t above) {
    points_.push_back({below, above});
    next_.push_back(kNone);
  }

  static constexpr int kLongestChain = 32;
  std::vector<std::uint32_t> first_;  // per vertex, kNone if no edge is cut
  std::vector<std::uint32_t> next_;   // per point, in the chain
  std::vector<Cut::Point>& points_;
  std::unordered_map<std::uint64_t, std::uint32_t> others_;
};

/// If all points are vertices, they are sorted in the order of the slab, so that the slice at a
/// layer is numbered like the input.
void numberAsInSlab(Cut& cut) {
  const bool allVertices = std::ranges::all_of(
      cut.points, [](const Cut::Point& point) { return point.below == point.above; });
  if (!allVertices) return;
  std::vector<std::uint32_t> order(cut.points.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::sort(order, {}, [&](std::uint32_t i) { return cut.points[i].below; });
  std::vector<std::uint32_t> number(order.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) number[order[i]] = i;
  std::ranges::sort(cut.points, {}, &Cut::Point::below);
  for (Triangle& triangle : cut.triangles) {
    for (std::uint32_t& corner : triangle) corner = number[corner];
  }
}

}  // namespace

Cut cutOf(std::span<const Cell> cells, std::span<const std::uint8_t> sides) {
  Cut cut;
  PointTable table(sides.size(), cut.points);
  const auto& all = sections();
  for (std::uint32_t index = 0; index < cells.size(); ++index) {
    const Cell& cell = cells[index];
    const std::array<std::uint8_t, 4> side = {sides[cell[0]], sides[cell[1]], sides[cell[2]],
                                              sides[cell[3]]};
    const unsigned pattern = (side[0] & 1U) | (side[1] & 1U) << 1U | (side[2] & 1U) << 2U |
                             (side[3] & 1U) << 3U;
    const Section& section = all[pattern];
    if (section.size == 0) continue;
    const bool touches = ((side[0] | side[1] | side[2] | side[3]) & Side::kOn) != 0;
    std::array<Cut::Point, 4> corner;
    for (int i = 0; i < section.size; ++i) {
      const auto [below, above] = section.edges[i];
      corner[i] = {cell[below], cell[above]};
      if (touches && (side[below] & Side::kOn) != 0) corner[i].above = cell[below];
      if (touches && (side[above] & Side::kOn) != 0) corner[i].below = corner[i].above;
    }
    const auto same = [&](int a, int b) {
      return corner[a].below == corner[b].below && corner[a].above == corner[b].above;
    };
    std::array<std::uint32_t, 4> number = {kNone, kNone, kNone, kNone};
    for (int i = 1; i + 1 < section.size; ++i) {
      if (touches && (same(0, i) || same(i, i + 1) || same(i + 1, 0))) continue;
      for (const int k : {0, i, i + 1}) {
        if (number[k] == kNone) number[k] = table.numberOf(corner[k].below, corner[k].above);
      }
      cut.triangles.push_back({number[0], number[i], number[i + 1]});
      cut.cells.push_back(index);
    }
  }
  numberAsInSlab(cut);
  return cut;
}

}  // namespace t4d::convert
