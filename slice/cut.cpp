#include "slice/cut.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace t4d::slice {
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

constexpr std::array<Section, 16> makeSections() {
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

constexpr std::array<Section, 16> kSections = makeSections();

}  // namespace

std::uint32_t PointNumbers::add(const Cut::Point& point) {
  points_.push_back(point);
  links_.push_back({point.above, model::kNoIndex});
  return static_cast<std::uint32_t>(points_.size() - 1);
}

std::uint32_t PointNumbers::find(const Cut::Point& point) {
  constexpr int kLongestChain = 32;
  std::uint32_t* link = &first_[point.below];
  for (int length = 0; *link != model::kNoIndex; ++length) {
    if (links_[*link].above == point.above) return *link;
    if (length == kLongestChain) {
      const std::uint64_t key = std::uint64_t{point.below} << 32U | point.above;
      const auto [found, isNew] = others_.try_emplace(key, model::kNoIndex);
      if (isNew) found->second = add(point);
      return found->second;
    }
    link = &links_[*link].next;
  }
  const auto number = static_cast<std::uint32_t>(points_.size());
  *link = number;  // before `add`, which may move the chain
  return add(point);
}

std::vector<std::uint32_t> numberAsInSlab(Cut& cut) {
  std::vector<std::uint32_t> order(cut.points.size());
  std::iota(order.begin(), order.end(), 0U);
  const bool allVertices = std::ranges::all_of(
      cut.points, [](const Cut::Point& point) { return point.below == point.above; });
  if (!allVertices) return order;
  std::ranges::sort(order, {}, [&](std::uint32_t i) { return cut.points[i].below; });
  std::vector<std::uint32_t> number(order.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) number[order[i]] = i;
  std::ranges::sort(cut.points, {}, &Cut::Point::below);
  for (Triangle& triangle : cut.triangles) {
    for (std::uint32_t& corner : triangle) corner = number[corner];
  }
  return order;
}

void CellCutter::addSection(const Cell& cell, unsigned pattern, std::uint32_t index) {
  const Section& section = kSections[pattern];
  const std::array<std::uint8_t, 4> side = {sides_[cell[0]], sides_[cell[1]], sides_[cell[2]],
                                            sides_[cell[3]]};
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
  std::array<std::uint32_t, 4> number = {model::kNoIndex, model::kNoIndex, model::kNoIndex,
                                         model::kNoIndex};
  for (int i = 1; i + 1 < section.size; ++i) {
    if (touches && (same(0, i) || same(i, i + 1) || same(i + 1, 0))) continue;
    for (const int k : {0, i, i + 1}) {
      if (number[k] == model::kNoIndex) number[k] = numbers_.of(corner[k]);
    }
    cut_.triangles.push_back({number[0], number[i], number[i + 1]});
    cut_.cells.push_back(index);
  }
}

void CellCutter::add(std::uint32_t begin, std::uint32_t end) {
  for (std::uint32_t index = begin; index < end; ++index) {
    const Cell& cell = cells_[index];
    const unsigned pattern = patternOf(cell);
    if (kSections[pattern].size != 0) addSection(cell, pattern, index);
  }
}

Cut CellCutter::finish() {
  numberAsInSlab(cut_);
  return std::move(cut_);
}

Cut cutOf(std::span<const Cell> cells, std::span<const std::uint8_t> sides) {
  CellCutter cutter(cells, sides);
  cutter.add(0, static_cast<std::uint32_t>(cells.size()));
  return cutter.finish();
}

}  // namespace t4d::slice
