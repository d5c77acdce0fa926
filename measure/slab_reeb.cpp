#include "measure/slab_reeb.h"

#include <algorithm>
#include <array>
#include <utility>

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

/// Finds the components of the slices in all slots, and which of one slot continue in the next.
///
/// Two cells with a common edge are of one component in all slots of that edge, which is a link
/// between them. Slots are halved again and again; cells that a link connects throughout a range
/// of slots are one item there and in all its parts, so that few of them are left to be divided
/// (offline dynamic connectivity). Items that nothing connects or divides within a range are a
/// segment of it.
class SlotParts {
 public:
  struct Segment {
    std::uint32_t firstSlot;
    std::uint32_t lastSlot;
    std::uint32_t cell;
    bool isNode;  ///< at an instant, with vertices
  };
  struct Item {
    std::uint32_t firstSlot;
    std::uint32_t lastSlot;
    std::uint32_t cell;
  };
  struct Link {
    std::uint32_t a;
    std::uint32_t b;
    std::uint32_t firstSlot;
    std::uint32_t lastSlot;
  };
  /// A vertex of an item, of which the segment is wanted.
  struct Mark {
    std::uint32_t vertex;
    std::uint32_t item;
  };
  struct Range {
    std::vector<Item> items;
    std::vector<Link> links;
    std::vector<Mark> marks;
  };

  SlotParts(std::span<const std::uint32_t> slotOfVertex)
      : slotOfVertex_(slotOfVertex), segmentOfVertex(slotOfVertex.size(), kNoIndex) {}

  /// Sets the segments of each item in the first and in the last slot, if it exists there.
  void find(std::uint32_t first, std::uint32_t last, Range whole,
            std::vector<std::uint32_t>& firsts, std::vector<std::uint32_t>& lasts) {
    divide(first, last, std::move(whole), firsts, lasts);
    std::ranges::sort(joins);
    joins.erase(std::unique(joins.begin(), joins.end()), joins.end());
  }

 private:
  /// Sets, for each item, its segments in the first and the last slot of the range, if it exists
  /// there.
  void divide(std::uint32_t first, std::uint32_t last, Range range,
              std::vector<std::uint32_t>& firsts, std::vector<std::uint32_t>& lasts) {
    const std::size_t given = range.items.size();
    model::UnionFind sets(given);
    for (const Link& link : range.links) {
      if (link.firstSlot <= first && link.lastSlot >= last) sets.unite(link.a, link.b);
    }
    std::vector<std::uint32_t> number(given);
    std::uint32_t count = 0;
    for (std::uint32_t i = 0; i < given; ++i) {
      const std::uint32_t root = sets.root(i);
      number[i] = root == i ? count : number[root];
      if (root == i) range.items[count++] = range.items[i];
    }
    range.items.resize(count);
    std::vector<char> divided(count, 0);
    std::size_t kept = 0;
    for (const Link& link : range.links) {
      const std::uint32_t a = number[link.a];
      const std::uint32_t b = number[link.b];
      if (a == b) continue;
      divided[a] = divided[b] = 1;
      range.links[kept++] = {a, b, link.firstSlot, link.lastSlot};
    }
    range.links.resize(kept);
    for (Mark& mark : range.marks) {
      mark.item = number[mark.item];
      if (first < last && slotOfVertex_[mark.vertex] % 2 == 0) divided[mark.item] = 1;
    }
    std::vector<std::uint32_t> firstOf(count, kNoIndex);
    std::vector<std::uint32_t> lastOf(count, kNoIndex);
    bool any = false;
    for (std::uint32_t i = 0; i < count; ++i) {
      if (divided[i] != 0 && first < last) {
        any = true;
        continue;
      }
      const Item& item = range.items[i];
      const auto segment = static_cast<std::uint32_t>(segments.size());
      segments.push_back(
          {std::max(first, item.firstSlot), std::min(last, item.lastSlot), item.cell, false});
      if (item.firstSlot <= first) firstOf[i] = segment;
      if (item.lastSlot >= last) lastOf[i] = segment;
      divided[i] = 0;
      ofItem_.push_back(segment);
    }
    settle(range, divided);
    if (any) halve(first, last, std::move(range), divided, firstOf, lastOf);
    firsts.resize(given);
    lasts.resize(given);
    for (std::size_t i = 0; i < given; ++i) {
      firsts[i] = firstOf[number[i]];
      lasts[i] = lastOf[number[i]];
    }
  }

  /// Notes the segments of the vertices of items that are not divided any more.
  void settle(Range& range, const std::vector<char>& divided) {
    std::vector<std::uint32_t> segmentOf(divided.size(), kNoIndex);
    std::size_t at = 0;
    for (std::size_t i = 0; i < divided.size(); ++i) {
      if (divided[i] == 0) segmentOf[i] = ofItem_[at++];
    }
    ofItem_.clear();
    std::size_t kept = 0;
    for (const Mark& mark : range.marks) {
      const std::uint32_t segment = segmentOf[mark.item];
      if (segment == kNoIndex) {
        range.marks[kept++] = mark;
        continue;
      }
      segmentOfVertex[mark.vertex] = segment;
      if (slotOfVertex_[mark.vertex] % 2 == 0) segments[segment].isNode = true;
    }
    range.marks.resize(kept);
  }

  void halve(std::uint32_t first, std::uint32_t last, Range range, const std::vector<char>& divided,
             std::vector<std::uint32_t>& firstOf, std::vector<std::uint32_t>& lastOf) {
    const std::uint32_t middle = first + (last - first) / 2;
    std::array<Range, 2> halves;
    std::array<std::vector<std::uint32_t>, 2> numbers;
    for (auto& ofHalf : numbers) ofHalf.assign(divided.size(), kNoIndex);
    for (std::uint32_t i = 0; i < divided.size(); ++i) {
      if (divided[i] == 0) continue;
      const Item& item = range.items[i];
      for (const int half : {0, 1}) {
        if (half == 0 ? item.firstSlot > middle : item.lastSlot <= middle) continue;
        numbers[half][i] = static_cast<std::uint32_t>(halves[half].items.size());
        halves[half].items.push_back(item);
      }
    }
    for (const Link& link : range.links) {
      for (const int half : {0, 1}) {
        if (half == 0 ? link.firstSlot > middle || link.lastSlot < first
                      : link.lastSlot <= middle || link.firstSlot > last) {
          continue;
        }
        halves[half].links.push_back(
            {numbers[half][link.a], numbers[half][link.b], link.firstSlot, link.lastSlot});
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

  std::span<const std::uint32_t> slotOfVertex_;
  std::vector<std::uint32_t> ofItem_;

 public:
  std::vector<Segment> segments;
  /// Segments, of which the second continues the first.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> joins;
  std::vector<std::uint32_t> segmentOfVertex;
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
  // Slots of the instants at the ends are left to setLayers.
  const auto isThroughout = [&](std::uint32_t first, std::uint32_t last) {
    return first <= 1 && last + 1 >= lastSlot;
  };
  const auto isBetween = [&](std::uint32_t first, std::uint32_t last) {
    return last > 0 && first < lastSlot;
  };
  const std::vector<model::Cell>& cells = connectivity.cells;
  Edges edges;
  edges.change2.assign(connectivity.vertexCount, 0);
  struct Seen {
    std::uint32_t from = kNoIndex;
    std::uint32_t cell = 0;
  };
  // Whether another edge of two cells links them in all slots of the edge from u to w: one that
  // lasts longer or, of those that last as long, has lower numbers.
  const auto isLinked = [&](std::uint32_t u, std::uint32_t w, const model::Cell& a,
                            const model::Cell& b) {
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
  };
  std::vector<Seen> seen(connectivity.vertexCount);
  model::UnionFind sets(cells.size());  // of cells that a link connects in all slots
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
        } else if (isBetween(first, last) && isThroughout(first, last)) {
          sets.unite(before.cell, index);
        } else if (isBetween(first, last) && !isLinked(u, w, cells[before.cell], cells[index])) {
          edges.range.links.push_back({before.cell, index, first, last});
        }
        before.cell = index;
      }
    }
  }
  std::vector<std::uint32_t>& number = edges.itemOfCell;
  number.assign(cells.size(), kNoIndex);
  std::vector<SlotParts::Item>& items = edges.range.items;
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    model::Cell cell = cells[i];
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
    const std::uint32_t root = sets.root(i);
    if (!isBetween(slots[cell[0]], slots[cell[3]])) continue;
    if (root == i) {
      number[i] = static_cast<std::uint32_t>(items.size());
      items.push_back({slots[cell[0]], slots[cell[3]], i});
    } else {
      number[i] = number[root];
    }
  }
  std::size_t kept = 0;
  for (SlotParts::Link& link : edges.range.links) {
    const std::uint32_t a = number[link.a];
    const std::uint32_t b = number[link.b];
    if (a != b) edges.range.links[kept++] = {a, b, link.firstSlot, link.lastSlot};
  }
  edges.range.links.resize(kept);
  for (std::uint32_t v = 0; v < connectivity.vertexCount; ++v) {
    const auto star = stars.of(v);
    if (!star.empty() && isBetween(slots[v], slots[v]))
      edges.range.marks.push_back({v, number[star.front()]});
  }
  return edges;
}

/// Of each interior node, the vertices of those pieces of one time that change the Euler number;
/// all, if none does.
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
