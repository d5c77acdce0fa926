#include "measure/level_flood.h"

#include <algorithm>
#include <utility>

#include "model/union_find.h"

namespace t4d::measure {

bool LevelFlood::goesOn(const model::Cell& cell, double time) const {
  bool before = false;
  bool after = false;
  for (const std::uint32_t vertex : cell) {
    (slab_.vertices[vertex][3] > time ? after : before) = true;
  }
  return before && after;
}

std::vector<FloodedSurface> LevelFlood::surfaces(double time, std::span<const std::uint32_t> from,
                                                 bool butOne) {
  constexpr int kPace = 16;  // cells of each in turn
  const std::vector<model::Cell>& cells = slab_.connectivity->cells;
  struct Front {
    std::vector<std::uint32_t> cells;
    std::size_t done = 0;  // of these, those whose neighbours are found
  };
  std::vector<Front> fronts;
  ++now_;
  for (const std::uint32_t cell : from) {
    if (round_[cell] == now_ || !goesOn(cells[cell], time)) continue;
    round_[cell] = now_;
    front_[cell] = static_cast<std::uint32_t>(fronts.size());
    fronts.push_back({{cell}});
  }
  model::UnionFind sets(fronts.size());
  std::vector<std::uint32_t> open(fronts.size());
  for (std::uint32_t i = 0; i < open.size(); ++i) open[i] = i;
  const auto meet = [&](std::uint32_t a, std::uint32_t b) {
    a = sets.root(a);
    b = sets.root(b);
    if (a == b) return;
    sets.unite(a, b);
    Front& kept = fronts[sets.root(a)];
    Front& other = fronts[sets.root(a) == a ? b : a];
    // Cells that are done stay in front.
    if (other.cells.size() > kept.cells.size()) std::swap(kept, other);
    const auto done = other.cells.begin() + static_cast<std::ptrdiff_t>(other.done);
    kept.cells.insert(kept.cells.end(), done, other.cells.end());
    // Each cell that is done is moved in front of one that is not.
    for (auto at = other.cells.begin(); at != done; ++at) {
      kept.cells.push_back(*at);
      std::swap(kept.cells.back(), kept.cells[kept.done++]);
    }
    other = {};
  };
  while (open.size() > (butOne ? 1U : 0U)) {
    for (const std::uint32_t number : open) {
      for (int k = 0; k < kPace; ++k) {
        const std::uint32_t root = sets.root(number);
        if (root != number || fronts[root].done == fronts[root].cells.size()) break;
        const std::uint32_t index = fronts[root].cells[fronts[root].done++];
        const model::Cell cell = cells[index];
        for (const std::uint32_t u : cell) {
          if (slab_.vertices[u][3] > time) continue;
          for (const std::uint32_t next : stars_.of(u)) {
            if (round_[next] == now_ && sets.root(front_[next]) == sets.root(number)) continue;
            const auto shares = [&](std::uint32_t w) {
              return slab_.vertices[w][3] > time && std::ranges::find(cell, w) != cell.end();
            };
            if (std::ranges::none_of(cells[next], shares)) continue;
            if (round_[next] == now_) {
              meet(front_[next], number);
              continue;
            }
            round_[next] = now_;
            front_[next] = sets.root(number);
            fronts[sets.root(number)].cells.push_back(next);
          }
        }
      }
    }
    std::erase_if(open, [&](std::uint32_t number) {
      return sets.root(number) != number || fronts[number].done == fronts[number].cells.size();
    });
  }
  std::vector<FloodedSurface> found;
  for (std::uint32_t i = 0; i < fronts.size(); ++i) {
    if (sets.root(i) != i) continue;
    const bool complete = fronts[i].done == fronts[i].cells.size();
    found.push_back({std::move(fronts[i].cells), complete});
  }
  return found;
}

}  // namespace t4d::measure
