#include "measure/slot_parts.h"

#include <algorithm>
#include <array>

#include "model/union_find.h"

namespace t4d::measure {

using model::kNoIndex;

void SlotParts::find(std::uint32_t first, std::uint32_t last, Range whole,
                     std::vector<std::uint32_t>& firsts, std::vector<std::uint32_t>& lasts) {
  divide(first, last, std::move(whole), firsts, lasts);
  std::ranges::sort(joins);
  joins.erase(std::unique(joins.begin(), joins.end()), joins.end());
}

/// Sets, for each item, its segments in the first and the last slot of the range, if it exists
/// there.
void SlotParts::divide(std::uint32_t first, std::uint32_t last, Range range,
                       std::vector<std::uint32_t>& firsts, std::vector<std::uint32_t>& lasts) {
  const auto isThroughout = [&](const auto& one) {
    return one.firstSlot <= first && one.lastSlot >= last;
  };
  const std::size_t given = range.items.size();
  model::UnionFind sets(given);
  for (const Link& link : range.links) {
    if (isThroughout(link)) sets.unite(link.a, link.b);
  }
  std::vector<std::uint32_t> number(given);
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < given; ++i) {
    const std::uint32_t root = sets.root(i);
    number[i] = root == i ? count : number[root];
    if (root == i) range.items[count++] = range.items[i];
    std::uint32_t& cell = range.items[number[i]].cell;
    cell = std::min(cell, range.items[i].cell);
  }
  range.items.resize(count);
  std::vector<char> divided(count, 0);
  for (Link& link : range.links) {
    link.a = number[link.a];
    link.b = number[link.b];
    if (link.a != link.b) divided[link.a] = divided[link.b] = 1;
  }
  std::erase_if(range.links, [](const Link& link) { return link.a == link.b; });
  for (Part& part : range.parts) {
    part.item = number[part.item];
    if (!isThroughout(part)) {
      divided[part.item] = 1;
      continue;
    }
    std::uint32_t& cell = range.items[part.item].cell;
    cell = std::min(cell, part.cell);
  }
  std::erase_if(range.parts, isThroughout);
  for (Mark& mark : range.marks) {
    mark.item = number[mark.item];
    if (slotOfVertex_[mark.vertex] % 2 == 0) divided[mark.item] = 1;
  }
  if (first == last) divided.assign(count, 0);
  std::vector<std::uint32_t> whole;
  for (std::uint32_t i = 0; i < count; ++i) {
    if (divided[i] == 0) whole.push_back(i);
  }
  std::ranges::sort(whole, {}, [&](std::uint32_t i) { return range.items[i].cell; });
  std::vector<std::uint32_t> firstOf(count, kNoIndex);
  std::vector<std::uint32_t> lastOf(count, kNoIndex);
  std::vector<std::uint32_t> segmentOf(count, kNoIndex);
  for (const std::uint32_t i : whole) {
    const Item& item = range.items[i];
    segmentOf[i] = static_cast<std::uint32_t>(segments.size());
    segments.push_back(
        {std::max(first, item.firstSlot), std::min(last, item.lastSlot), item.cell, false});
    if (item.firstSlot <= first) firstOf[i] = segmentOf[i];
    if (item.lastSlot >= last) lastOf[i] = segmentOf[i];
  }
  settle(range, segmentOf);
  if (whole.size() < count) halve(first, last, std::move(range), divided, firstOf, lastOf);
  firsts.resize(given);
  lasts.resize(given);
  for (std::size_t i = 0; i < given; ++i) {
    firsts[i] = firstOf[number[i]];
    lasts[i] = lastOf[number[i]];
  }
}

/// Notes the segments of the vertices of items that are not divided any more.
void SlotParts::settle(Range& range, std::span<const std::uint32_t> segmentOf) {
  std::erase_if(range.marks, [&](const Mark& mark) {
    const std::uint32_t segment = segmentOf[mark.item];
    if (segment == kNoIndex) return false;
    segmentOfVertex[mark.vertex] = segment;
    if (slotOfVertex_[mark.vertex] % 2 == 0) segments[segment].isNode = true;
    return true;
  });
}

void SlotParts::halve(std::uint32_t first, std::uint32_t last, Range range,
                      const std::vector<char>& divided, std::vector<std::uint32_t>& firstOf,
                      std::vector<std::uint32_t>& lastOf) {
  const std::uint32_t middle = first + (last - first) / 2;
  const auto isIn = [&](const auto& one, int half) {
    return half == 0 ? one.firstSlot <= middle && one.lastSlot >= first
                     : one.lastSlot > middle && one.firstSlot <= last;
  };
  std::array<Range, 2> halves;
  std::array<std::vector<std::uint32_t>, 2> numbers;
  for (const int half : {0, 1}) {
    std::vector<std::uint32_t>& number = numbers[half];
    number.assign(divided.size(), kNoIndex);
    for (std::uint32_t i = 0; i < divided.size(); ++i) {
      if (divided[i] == 0 || !isIn(range.items[i], half)) continue;
      number[i] = static_cast<std::uint32_t>(halves[half].items.size());
      halves[half].items.push_back(range.items[i]);
    }
    for (const Link& link : range.links) {
      if (!isIn(link, half)) continue;
      halves[half].links.push_back({number[link.a], number[link.b], link.firstSlot, link.lastSlot});
    }
    for (const Part& part : range.parts) {
      if (!isIn(part, half)) continue;
      halves[half].parts.push_back({number[part.item], part.firstSlot, part.lastSlot, part.cell});
    }
  }
  for (const Mark& mark : range.marks) {
    const int half = slotOfVertex_[mark.vertex] <= middle ? 0 : 1;
    halves[half].marks.push_back({mark.vertex, numbers[half][mark.item]});
  }
  range = {};
  std::array<std::vector<std::uint32_t>, 2> firsts;
  std::array<std::vector<std::uint32_t>, 2> lasts;
  divide(first, middle, std::move(halves[0]), firsts[0], lasts[0]);
  divide(middle + 1, last, std::move(halves[1]), firsts[1], lasts[1]);
  for (std::uint32_t i = 0; i < divided.size(); ++i) {
    if (divided[i] == 0) continue;
    const std::uint32_t before = numbers[0][i];
    const std::uint32_t after = numbers[1][i];
    if (before != kNoIndex) firstOf[i] = firsts[0][before];
    if (after != kNoIndex) lastOf[i] = lasts[1][after];
    if (before == kNoIndex || after == kNoIndex) continue;
    const std::uint32_t below = lasts[0][before];
    const std::uint32_t above = firsts[1][after];
    if (below != kNoIndex && above != kNoIndex) joins.emplace_back(below, above);
  }
}

}  // namespace t4d::measure
