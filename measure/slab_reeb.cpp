#include "measure/slab_reeb.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>
#include <optional>
#include <utility>

#include "measure/slot_parts.h"
#include "measure/vertex_stars.h"
#include "model/union_find.h"
#include "t4d/mesh.h"

namespace t4d::measure {
namespace {

using model::kNoIndex;

/// Tells where the topology of slices changes from the cells around vertices.
class LinkTest {
 public:
  LinkTest(const model::Connectivity& connectivity, const VertexStars& stars,
           std::span<const double> times)
      : cells_(connectivity.cells),
        stars_(stars),
        times_(times),
        seen_(times.size()),
        number_(connectivity.cells.size(), kNoIndex) {}

  /// Whether the slices just before and just after some vertices of one time, which edges connect,
  /// are alike around them: one piece each, with the same Euler number.
  bool isRegular(std::span<const std::uint32_t> vertices) {
    if (vertices.size() == 1) {
      if (const auto regular = isRegularAlone(vertices.front())) return *regular;
    }
    const double time = times_[vertices.front()];
    ++round_;
    touched_.clear();
    for (Side& side : sides_) side = {};
    std::int64_t change2 = 0;
    for (const std::uint32_t vertex : vertices) {
      for (const std::uint32_t index : stars_.of(vertex)) {
        const model::Cell& cell = cells_[index];
        if (number_[index] == kNoIndex) {
          number_[index] = static_cast<std::uint32_t>(touched_.size());
          touched_.push_back(index);
          change2 += changeIn(cell, time);
        }
        for (const std::uint32_t other : cell) {
          if (times_[other] == time) continue;
          const int after = times_[other] > time ? 1 : 0;
          Seen& seen = seen_[other];
          if (seen.round != round_ || seen.from != vertex) {
            seen = {round_, vertex, number_[index]};
            change2 += after == 1 ? 2 : -2;
            sides_[after].add(number_[index]);
          } else {
            sides_[after].unite(seen.cell, number_[index]);
            seen.cell = number_[index];
          }
        }
      }
    }
    for (const std::uint32_t index : touched_) number_[index] = kNoIndex;
    return change2 == 0 && sides_[0].pieces == 1 && sides_[1].pieces == 1;
  }

 private:
  struct Seen {
    std::uint32_t round = 0;
    std::uint32_t from = 0;
    std::uint32_t cell = 0;
  };
  /// Cells with a part before the time, or with one after it, and how they are connected.
  struct Side {
    std::vector<std::uint32_t> parent = {};
    std::int64_t pieces = 0;

    std::uint32_t root(std::uint32_t item) {
      while (parent[item] != item) item = parent[item] = parent[parent[item]];
      return item;
    }
    void add(std::uint32_t cell) {
      for (auto next = static_cast<std::uint32_t>(parent.size()); next <= cell; ++next) {
        parent.push_back(kNoIndex);
      }
      if (parent[cell] != kNoIndex) return;
      parent[cell] = cell;
      ++pieces;
    }
    void unite(std::uint32_t a, std::uint32_t b) {
      add(b);
      a = root(a);
      b = root(b);
      if (a != b) --pieces;
      parent[std::max(a, b)] = std::min(a, b);
    }
  };

  /// The same of a vertex that has no more than 64 neighbours, of other times.
  std::optional<bool> isRegularAlone(std::uint32_t vertex) {
    const double time = times_[vertex];
    ++round_;
    std::uint32_t count = 0;
    std::uint64_t after = 0;  // a bit for each neighbour, as in all these sets
    std::array<std::uint64_t, 64> next;
    std::int64_t change2 = 0;
    for (const std::uint32_t index : stars_.of(vertex)) {
      std::uint64_t corners = 0;
      for (const std::uint32_t other : cells_[index]) {
        if (other == vertex) continue;
        Seen& seen = seen_[other];
        if (seen.round != round_) {
          if (count == next.size()) return {};
          seen = {round_, vertex, count};
          next[count] = 0;
          const bool isAfter = times_[other] > time;
          change2 += isAfter ? 2 : -2;
          if (isAfter) after |= std::uint64_t{1} << count;
          ++count;
        }
        corners |= std::uint64_t{1} << seen.cell;
      }
      const std::uint64_t later = corners & after;
      change2 += (later & (later - 1)) != 0 ? -1 : 1;  // two or more
      for (std::uint64_t rest = corners; rest != 0; rest &= rest - 1) {
        next[static_cast<std::size_t>(std::countr_zero(rest))] |= corners;
      }
    }
    if (change2 != 0 || count == 0) return false;
    const auto isOnePiece = [&](std::uint64_t side) {
      std::uint64_t front = side & (~side + 1);
      while (front != 0) {
        const auto at = static_cast<std::size_t>(std::countr_zero(front));
        side &= ~(std::uint64_t{1} << at);
        front = (front | next[at]) & side;
      }
      return side == 0;
    };
    const std::uint64_t before = (~std::uint64_t{0} >> (64 - count)) & ~after;
    return before != 0 && after != 0 && isOnePiece(before) && isOnePiece(after);
  }

  /// What the corners of a cell at a time add to twice the Euler number (edgesOf).
  std::int64_t changeIn(const model::Cell& cell, double time) const {
    int before = 0;
    int at = 0;
    for (const std::uint32_t corner : cell) {
      before += times_[corner] < time ? 1 : 0;
      at += times_[corner] == time ? 1 : 0;
    }
    std::int64_t sum = 0;
    for (int rank = before; rank < before + at; ++rank) sum += rank < 2 ? -1 : 1;
    return sum;
  }

  const std::vector<model::Cell>& cells_;
  const VertexStars& stars_;
  std::span<const double> times_;
  std::vector<Seen> seen_;
  std::vector<std::uint32_t> number_;  // of a cell in this round
  std::vector<std::uint32_t> touched_;
  std::array<Side, 2> sides_;
  std::uint32_t round_ = 0;
};

/// Finds the instants, and sets the slots of vertices.
void setSlots(const model::Slab& slab, const VertexStars& stars, std::span<const double> times,
              SlabReeb& reeb) {
  const model::Connectivity& connectivity = *slab.connectivity;
  const auto isInside = [&](std::uint32_t v) {
    return slab.timeBegin < times[v] && times[v] < slab.timeEnd && !stars.of(v).empty();
  };
  model::UnionFind pieces(connectivity.vertexCount);
  bool alone = true;
  for (const model::Cell& cell : connectivity.cells) {
    for (int i = 0; i < 3; ++i) {
      if (cell[i] < connectivity.lowerCount || cell[i] >= connectivity.firstUpper()) continue;
      for (int j = i + 1; j < 4; ++j) {
        if (times[cell[i]] != times[cell[j]]) continue;
        pieces.unite(cell[i], cell[j]);
        alone = false;
      }
    }
  }
  std::vector<std::uint32_t> inside;
  for (std::uint32_t v = connectivity.lowerCount; v < connectivity.firstUpper(); ++v) {
    if (isInside(v)) inside.push_back(v);
  }
  const auto pieceOf = [&](std::uint32_t v) { return pieces.root(v); };
  if (!alone) std::ranges::stable_sort(inside, {}, pieceOf);
  std::vector<std::uint32_t>& between = reeb.between;
  LinkTest test(connectivity, stars, times);
  for (std::size_t i = 0; i < inside.size();) {
    const std::size_t first = i++;
    while (!alone && i < inside.size() && pieceOf(inside[i]) == pieceOf(inside[first])) ++i;
    if (!test.isRegular(std::span(inside).subspan(first, i - first))) {
      between.push_back(inside[first]);
    }
  }
  const auto timeOf = [&](std::uint32_t v) { return times[v]; };
  std::ranges::stable_sort(between, {}, timeOf);
  const auto repeated = std::ranges::unique(between, {}, timeOf);
  between.erase(repeated.begin(), repeated.end());
  const std::vector<double> instants = instantsOf(reeb, slab);
  reeb.lastInstant = static_cast<std::uint32_t>(instants.size() - 1);
  reeb.slotOfVertex.resize(connectivity.vertexCount);
  for (std::uint32_t v = 0; v < connectivity.vertexCount; ++v) {
    const auto at = std::ranges::lower_bound(instants, times[v]);
    const auto k = static_cast<std::uint32_t>(at - instants.begin());
    reeb.slotOfVertex[v] = *at == times[v] ? 2 * k : 2 * k - 1;
  }
}

/// Slots between those of the layers, whose instants are left to addLayer; none if the first is
/// greater than the last.
struct Life {
  std::uint32_t first = 0;
  std::uint32_t last = 0;
  bool operator==(const Life&) const = default;
};

/// What was seen last of some numbers, so that most of what is repeated is found at once.
template <typename One>
class RecentlySeen {
 public:
  One& of(std::uint32_t a, std::uint32_t b) {
    constexpr std::uint32_t kFactor = 2654435761;  // Knuth, section 6.4
    return ones_[((a * kFactor + b) * kFactor) >> (32 - kBits)];
  }

 private:
  static constexpr int kBits = 12;
  std::vector<One> ones_ = std::vector<One>(std::size_t{1} << kBits);
};

/// Puts cells into items: a cell that an edge links to another one for as long as it lasts is a
/// part of that one's item.
class CellItems {
 public:
  /// The lives of the cells.
  explicit CellItems(std::vector<Life> lives) : lives_(std::move(lives)), parent_(lives_.size()) {
    std::iota(parent_.begin(), parent_.end(), 0U);
  }

  bool areOne(std::uint32_t a, std::uint32_t b) { return root(a) == root(b); }

  /// Links two cells for the life of an edge of both. False if that does not make them one item.
  bool link(std::uint32_t a, std::uint32_t b, Life edge) {
    a = root(a);
    b = root(b);
    if (lives_[a] == edge) {
      parent_[a] = b;
    } else if (lives_[b] == edge) {
      parent_[b] = a;
    } else {
      return false;
    }
    return true;
  }

  /// Adds the items and the parts. Sets the item of each cell, or model::kNoIndex.
  std::vector<std::uint32_t> add(SlotParts::Range& range) {
    const auto count = static_cast<std::uint32_t>(lives_.size());
    std::vector<std::uint32_t> number(count, kNoIndex);
    for (std::uint32_t i = 0; i < count; ++i) {
      if (root(i) != i || lives_[i].first > lives_[i].last) continue;
      number[i] = static_cast<std::uint32_t>(range.items.size());
      range.items.push_back({lives_[i].first, lives_[i].last, i});
    }
    RecentlySeen<SlotParts::Part> recent;
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint32_t of = root(i);
      number[i] = number[of];
      if (of == i || number[i] == kNoIndex) continue;
      const auto [first, last] = lives_[i];
      if (lives_[i] == lives_[of]) {
        std::uint32_t& cell = range.items[number[i]].cell;
        cell = std::min(cell, i);
        continue;
      }
      SlotParts::Part& before = recent.of(number[i], first);
      if (before.item == number[i] && before.firstSlot == first && before.lastSlot == last)
        continue;
      before = {number[i], first, last, i};
      range.parts.push_back(before);
    }
    return number;
  }

 private:
  std::uint32_t root(std::uint32_t cell) {
    while (parent_[cell] != cell) cell = parent_[cell] = parent_[parent_[cell]];
    return cell;
  }

  std::vector<Life> lives_;
  std::vector<std::uint32_t> parent_;  // lasts as long or longer
};

/// Whether another edge of two cells links them in all slots of the edge from u to w: one that
/// lasts longer or, of those that last as long, has lower numbers.
bool isLinked(std::uint32_t u, std::uint32_t w, const model::Cell& a, const model::Cell& b,
              std::span<const std::uint32_t> slots) {
  const auto [first, last] = std::minmax(slots[u], slots[w]);
  for (const std::uint32_t x : a) {
    if (x == u || x == w || std::ranges::find(b, x) == b.end()) continue;
    for (const std::uint32_t end : {u, w}) {
      const auto [begin, behind] = std::minmax(slots[end], slots[x]);
      if (begin > first || behind < last) continue;
      if (begin < first || behind > last) return true;
      if (std::minmax(end, x) < std::pair<const std::uint32_t&, const std::uint32_t&>(u, w)) {
        return true;
      }
    }
  }
  return false;
}

struct Edges {
  SlotParts::Range range;
  std::vector<std::uint32_t> itemOfCell;  // model::kNoIndex of a cell within a layer
  /// At each vertex, twice what it adds to the Euler number of a slice.
  std::vector<std::int32_t> change2;
  /// Edges between two vertices of one time between the layers.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> flat;
};

/// A slice has a vertex on each edge that it cuts; of each cell a triangle or a quadrilateral, of
/// which each side has another.
Edges edgesOf(const model::Connectivity& connectivity, const VertexStars& stars,
              std::span<const double> times, const SlabReeb& reeb) {
  const std::vector<std::uint32_t>& slots = reeb.slotOfVertex;
  const std::uint32_t lastSlot = 2 * reeb.lastInstant;
  const auto lifeOf = [&](std::uint32_t begin, std::uint32_t end) {
    return Life{std::max(begin, 1U), std::min(end + 1, std::max(lastSlot, 1U)) - 1};
  };
  const std::vector<model::Cell>& cells = connectivity.cells;
  Edges edges;
  edges.change2.assign(connectivity.vertexCount, 0);
  std::vector<Life> lives;
  lives.reserve(cells.size());
  for (model::Cell cell : cells) {
    const auto order = [&](int a, int b) {
      if (times[cell[b]] < times[cell[a]]) std::swap(cell[a], cell[b]);
    };
    order(0, 1);
    order(2, 3);
    order(0, 2);
    order(1, 3);
    order(1, 2);
    edges.change2[cell[0]] -= 1;
    edges.change2[cell[1]] -= 1;
    edges.change2[cell[2]] += 1;
    edges.change2[cell[3]] += 1;
    lives.push_back(lifeOf(slots[cell[0]], slots[cell[3]]));
  }
  CellItems items(std::move(lives));
  struct Seen {
    std::uint32_t from = kNoIndex;
    std::uint32_t cell = 0;
  };
  std::vector<Seen> seen(connectivity.vertexCount);
  for (std::uint32_t u = 0; u < connectivity.vertexCount; ++u) {
    for (const std::uint32_t index : stars.of(u)) {
      for (const std::uint32_t w : cells[index]) {
        if (w <= u) continue;
        Seen& before = seen[w];
        const auto [first, last] = std::minmax(slots[u], slots[w]);
        if (before.from != u) {
          before.from = u;
          if (times[u] != times[w]) {
            edges.change2[times[u] < times[w] ? u : w] += 2;
            edges.change2[times[u] < times[w] ? w : u] -= 2;
          } else if (first % 2 == 0 && first != 0 && first != lastSlot) {
            edges.flat.emplace_back(u, w);
          }
        } else if (!items.areOne(before.cell, index) && last > 0 && first < lastSlot) {
          const Life life = lifeOf(first, last);
          if (!items.link(before.cell, index, life) &&
              !isLinked(u, w, cells[before.cell], cells[index], slots)) {
            edges.range.links.push_back({before.cell, index, life.first, life.last});
          }
        }
        before.cell = index;
      }
    }
  }
  std::vector<std::uint32_t>& number = edges.itemOfCell;
  number = items.add(edges.range);
  RecentlySeen<SlotParts::Link> recent;
  std::size_t kept = 0;
  for (SlotParts::Link link : edges.range.links) {
    link.a = number[link.a];
    link.b = number[link.b];
    if (link.a == link.b) continue;
    SlotParts::Link& before = recent.of(link.a, link.b);
    if (before.a == link.a && before.b == link.b && before.firstSlot <= link.firstSlot &&
        before.lastSlot >= link.lastSlot) {
      continue;
    }
    before = link;
    edges.range.links[kept++] = link;
  }
  edges.range.links.resize(kept);
  for (std::uint32_t v = 0; v < connectivity.vertexCount; ++v) {
    const auto star = stars.of(v);
    if (!star.empty() && slots[v] > 0 && slots[v] < lastSlot) {
      edges.range.marks.push_back({v, number[star.front()]});
    }
  }
  return edges;
}

/// Sets the vertices of each interior node: those of the pieces of one time that change the Euler
/// number, or all if none does.
void setPlaces(const SlotParts& parts, const std::vector<std::uint32_t>& nodeOfSegment,
               const Edges& edges, SlabReeb& reeb) {
  const auto count = static_cast<std::uint32_t>(reeb.slotOfVertex.size());
  model::UnionFind pieces(count);
  for (const auto& [a, b] : edges.flat) pieces.unite(a, b);
  std::vector<std::int64_t> change2(count, 0);
  const auto nodeOf = [&](std::uint32_t v) {
    const std::uint32_t segment = parts.segmentOfVertex[v];
    if (segment == kNoIndex || !parts.segments[segment].isNode) return kNoIndex;
    return nodeOfSegment[segment];
  };
  for (std::uint32_t v = 0; v < count; ++v) {
    if (nodeOf(v) != kNoIndex) change2[pieces.root(v)] += edges.change2[v];
  }
  for (const bool all : {false, true}) {
    std::vector<char> filled(reeb.nodes.size(), 0);
    for (std::uint32_t n = 0; n < reeb.nodes.size(); ++n) {
      filled[n] = reeb.nodes[n].vertices.empty() ? 0 : 1;
    }
    for (std::uint32_t v = 0; v < count; ++v) {
      const std::uint32_t node = nodeOf(v);
      if (node == kNoIndex || filled[node] != 0) continue;
      if (all || change2[pieces.root(v)] != 0) reeb.nodes[node].vertices.push_back(v);
    }
  }
}

/// Adds the nodes of an instant at an end of the slab: vertices of one cell there are of one, and
/// so are the arcs of their cells. Returns the nodes of vertices.
std::vector<std::uint32_t> addLayer(const model::Connectivity& connectivity, const Edges& edges,
                                    const std::vector<std::uint32_t>& arcOfCell,
                                    std::uint32_t instant, std::uint32_t SlabReeb::Arc::*end,
                                    SlabReeb& reeb) {
  const std::uint32_t count = connectivity.vertexCount;
  model::UnionFind sets(count + reeb.arcs.size());
  std::vector<char> used(count, 0);
  for (std::size_t i = 0; i < connectivity.cells.size(); ++i) {
    std::uint32_t with = arcOfCell[i] == kNoIndex ? kNoIndex : count + arcOfCell[i];
    for (const std::uint32_t vertex : connectivity.cells[i]) {
      if (reeb.slotOfVertex[vertex] != 2 * instant) continue;
      used[vertex] = 1;
      if (with != kNoIndex) sets.unite(vertex, with);
      with = vertex;
    }
  }
  std::vector<std::uint32_t> nodes(count, kNoIndex);
  for (std::uint32_t v = 0; v < count; ++v) {
    if (used[v] == 0) continue;
    const std::uint32_t root = sets.root(v);  // a vertex: it is the smallest
    if (root == v) {
      nodes[v] = static_cast<std::uint32_t>(reeb.nodes.size());
      reeb.nodes.push_back({instant, 0});
    }
    nodes[v] = nodes[root];
    reeb.nodes[nodes[v]].eulerChange2 += edges.change2[v];
  }
  for (std::uint32_t a = 0; a < reeb.arcs.size(); ++a) {
    const std::uint32_t root = sets.root(count + a);
    if (root < count) reeb.arcs[a].*end = nodes[root];
  }
  return nodes;
}

void setGraph(const model::Connectivity& connectivity, const SlotParts& parts, const Edges& edges,
              const std::vector<std::uint32_t>& firsts, const std::vector<std::uint32_t>& lasts,
              SlabReeb& reeb) {
  const auto segmentCount = static_cast<std::uint32_t>(parts.segments.size());
  const auto isNode = [&](std::uint32_t segment) { return parts.segments[segment].isNode; };
  model::UnionFind arcs(segmentCount);
  std::vector<std::uint32_t> below(segmentCount, kNoIndex);  // of an arc: the segment of its node
  std::vector<std::uint32_t> above(segmentCount, kNoIndex);
  for (const auto& [a, b] : parts.joins) {
    if (!isNode(a) && !isNode(b)) arcs.unite(a, b);
  }
  for (const auto& [a, b] : parts.joins) {
    if (isNode(a)) below[arcs.root(b)] = a;
    if (isNode(b)) above[arcs.root(a)] = b;
  }
  std::vector<std::int64_t> change2(segmentCount, 0);
  for (std::uint32_t v = 0; v < connectivity.vertexCount; ++v) {
    const std::uint32_t segment = parts.segmentOfVertex[v];
    if (segment != kNoIndex) change2[segment] += edges.change2[v];
  }
  // Nodes where nothing happens are left out.
  std::vector<std::uint32_t> countBelow(segmentCount, 0);
  std::vector<std::uint32_t> countAbove(segmentCount, 0);
  std::vector<std::uint32_t> arcBelow(segmentCount, kNoIndex);
  std::vector<std::uint32_t> arcAbove(segmentCount, kNoIndex);
  for (std::uint32_t s = 0; s < segmentCount; ++s) {
    if (isNode(s) || arcs.root(s) != s) continue;
    if (below[s] != kNoIndex) {
      ++countAbove[below[s]];
      arcAbove[below[s]] = s;
    }
    if (above[s] != kNoIndex) {
      ++countBelow[above[s]];
      arcBelow[above[s]] = s;
    }
  }
  std::vector<std::uint32_t> nodeOfSegment(segmentCount, kNoIndex);
  for (std::uint32_t s = 0; s < segmentCount; ++s) {
    if (!isNode(s)) continue;
    const std::uint32_t slot = parts.segments[s].firstSlot;
    if (countBelow[s] == 1 && countAbove[s] == 1 && change2[s] == 0) {
      const std::uint32_t lower = arcs.root(arcBelow[s]);
      const std::uint32_t upper = arcs.root(arcAbove[s]);
      const std::uint32_t bottom = below[lower];
      const std::uint32_t top = above[upper];
      arcs.unite(lower, upper);
      below[arcs.root(lower)] = bottom;
      above[arcs.root(lower)] = top;
      continue;
    }
    nodeOfSegment[s] = static_cast<std::uint32_t>(reeb.nodes.size());
    reeb.nodes.push_back({slot / 2, change2[s]});
  }
  const auto nodeOf = [&](std::uint32_t segment) {
    return segment == kNoIndex ? kNoIndex : nodeOfSegment[segment];
  };
  std::vector<std::uint32_t> number(segmentCount, kNoIndex);
  for (std::uint32_t s = 0; s < segmentCount; ++s) {
    if (isNode(s) || arcs.root(s) != s) continue;
    number[s] = static_cast<std::uint32_t>(reeb.arcs.size());
    reeb.arcs.push_back({nodeOf(below[s]), nodeOf(above[s])});
  }
  for (std::uint32_t s = 0; s < segmentCount; ++s) {
    if (isNode(s)) continue;
    const SlotParts::Segment& segment = parts.segments[s];
    reeb.stretches.push_back(
        {number[arcs.root(s)], segment.firstSlot, segment.lastSlot, segment.cell});
  }
  reeb.arcOfVertex.assign(connectivity.vertexCount, kNoIndex);
  for (std::uint32_t v = 0; v < connectivity.vertexCount; ++v) {
    const std::uint32_t segment = parts.segmentOfVertex[v];
    if (segment != kNoIndex && !isNode(segment)) reeb.arcOfVertex[v] = number[arcs.root(segment)];
  }
  const auto arcsOf = [&](const std::vector<std::uint32_t>& segments) {
    std::vector<std::uint32_t> ofCells(connectivity.cells.size(), kNoIndex);
    for (std::size_t i = 0; i < ofCells.size(); ++i) {
      const std::uint32_t item = edges.itemOfCell[i];
      const std::uint32_t segment = item == kNoIndex ? kNoIndex : segments[item];
      if (segment != kNoIndex) ofCells[i] = number[arcs.root(segment)];
    }
    return ofCells;
  };
  std::vector<std::uint32_t> nodeOfVertex =
      addLayer(connectivity, edges, arcsOf(firsts), 0, &SlabReeb::Arc::below, reeb);
  reeb.nodeOfLower.assign(nodeOfVertex.begin(), nodeOfVertex.begin() + connectivity.lowerCount);
  if (reeb.lastInstant > 0) {
    nodeOfVertex =
        addLayer(connectivity, edges, arcsOf(lasts), reeb.lastInstant, &SlabReeb::Arc::above, reeb);
  }
  reeb.nodeOfUpper.assign(nodeOfVertex.begin() + connectivity.firstUpper(), nodeOfVertex.end());
  setPlaces(parts, nodeOfSegment, edges, reeb);
}

}  // namespace

std::vector<double> instantsOf(const SlabReeb& reeb, const model::Slab& slab) {
  std::vector<double> instants = {slab.timeBegin};
  for (const std::uint32_t vertex : reeb.between) instants.push_back(slab.vertices[vertex][3]);
  if (slab.timeEnd > slab.timeBegin) instants.push_back(slab.timeEnd);
  return instants;
}

std::uint32_t slotAfter(std::span<const double> instants, double time) {
  const auto after = std::ranges::upper_bound(instants, time);
  return static_cast<std::uint32_t>(2 * (after - instants.begin()) - 1);
}

SlabReeb slabReeb(const model::Slab& slab) {
  const model::Connectivity& connectivity = *slab.connectivity;
  std::vector<double> times(connectivity.vertexCount);
  for (std::uint32_t v = 0; v < connectivity.vertexCount; ++v) times[v] = slab.vertices[v][3];
  const VertexStars stars(connectivity);
  SlabReeb reeb;
  setSlots(slab, stars, times, reeb);
  Edges edges = edgesOf(connectivity, stars, times, reeb);
  SlotParts parts(reeb.slotOfVertex);
  std::vector<std::uint32_t> firsts;
  std::vector<std::uint32_t> lasts;
  if (reeb.lastInstant > 0) {
    parts.find(1, 2 * reeb.lastInstant - 1, std::move(edges.range), firsts, lasts);
  }
  setGraph(connectivity, parts, edges, firsts, lasts, reeb);
  return reeb;
}

}  // namespace t4d::measure
