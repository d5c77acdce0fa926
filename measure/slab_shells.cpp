#include "measure/slab_shells.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <unordered_map>
#include <utility>

#include "measure/level_surfaces.h"

namespace t4d::measure {
namespace {

using model::kNoIndex;
using model::Point3;

struct ArcInterval {
  std::uint32_t arc;
  double begin;
  double end;
};

/// Returns as few times as possible, so that each interval has one inside.
std::vector<double> piercing(std::vector<ArcInterval> intervals) {
  std::ranges::sort(intervals, {}, &ArcInterval::end);
  std::vector<double> times;
  for (std::size_t i = 0; i < intervals.size();) {
    const double end = intervals[i].end;
    double begin = intervals[i].begin;
    while (i < intervals.size() && intervals[i].begin < end) {
      begin = std::max(begin, intervals[i++].begin);
    }
    times.push_back(begin + (end - begin) / 2);
    // Intervals that begin before this time and end later have it inside, too.
    const double time = times.back();
    const auto pierced = [&](const ArcInterval& interval) { return interval.begin < time; };
    intervals.erase(std::remove_if(intervals.begin() + static_cast<std::ptrdiff_t>(i),
                                   intervals.end(), pierced),
                    intervals.end());
  }
  return times;
}

}  // namespace

SlabShells::SlabShells(const model::Slab& slab, const MeasuredSlab& measured)
    : shellOfArc(measured.topology->reeb.arcs.size(), kNoIndex),
      slab_(slab),
      measured_(measured),
      arcsBelow_(reeb().nodes.size()),
      arcsAbove_(reeb().nodes.size()) {
  for (std::uint32_t a = 0; a < reeb().arcs.size(); ++a) {
    const auto [below, above] = reeb().arcs[a];
    if (below != kNoIndex) arcsAbove_[below].push_back(a);
    if (above != kNoIndex) arcsBelow_[above].push_back(a);
  }
}

LevelFlood& SlabShells::flooding() {
  if (!flood_) flood_ = std::make_unique<LevelFlood>(slab_);
  return *flood_;
}

void SlabShells::make(Transition& one, bool solids, std::vector<Shell>& shells) {
  std::optional<bool> outer;
  if (one.arcsAbove.size() == 1) {
    const auto isOuter = [&](std::uint32_t shell) { return shells[shell].outer; };
    const auto outers = std::ranges::count_if(one.shellsBelow, isOuter);
    if (one.shellsBelow.empty() && one.node != kNoIndex) {
      outer = birthIsOuter(one.node);
    } else if (outers == 0 || outers == std::ssize(one.shellsBelow)) {
      // What merges outside is one outside, what merges within a solid is one cavity.
      outer = outers != 0;
    } else if (one.shellsBelow.size() == 2 && solids) {
      // A cavity opens to the outside, or a solid within a cavity reaches its wall.
      outer = shells[one.shellsBelow[0]].solid == shells[one.shellsBelow[1]].solid;
    }
  }
  std::vector<Shell> made;
  if (outer) {
    Shell shell;
    shell.outer = *outer;
    shell.euler2 = one.change2;
    for (const std::uint32_t below : one.shellsBelow) {
      shell.euler2 += shells[below].euler2;
      shell.volume += shells[below].volume;
    }
    made.push_back(shell);
  } else if (!splitLocally(one, shells, made)) {
    made.clear();
    evaluate(one.arcsAbove);
    for (const std::uint32_t arc : one.arcsAbove) {
      const ArcValue& value = values_[arc];
      Shell shell;
      shell.outer = value.measures.volume >= 0;
      shell.euler2 = value.euler2;
      shell.volume = std::abs(value.measures.volume);
      made.push_back(shell);
    }
  }
  for (std::size_t i = 0; i < made.size(); ++i) {
    shellOfArc[one.arcsAbove[i]] = static_cast<std::uint32_t>(shells.size());
    one.shellsAbove.push_back(static_cast<std::uint32_t>(shells.size()));
    shells.push_back(made[i]);
  }
}

std::vector<Transition> SlabShells::transitionsAt(std::span<const std::uint32_t> nodes) const {
  std::vector<Transition> transitions;
  for (const std::uint32_t number : nodes) {
    const SlabReeb::Node& node = reeb().nodes[number];
    Transition one;
    one.change2 = node.eulerChange2;
    one.node = number;
    one.arcsAbove = arcsAbove_[number];
    for (const std::uint32_t arc : arcsBelow_[number]) {
      if (shellOfArc[arc] != kNoIndex) one.shellsBelow.push_back(shellOfArc[arc]);
    }
    for (const std::uint32_t vertex : node.vertices) {
      one.placeSum += slab_.vertices[vertex].head<3>();
      ++one.placeCount;
    }
    transitions.push_back(std::move(one));
  }
  return transitions;
}

std::vector<std::uint32_t> SlabShells::nodesInOrder() const {
  std::vector<std::uint32_t> nodes;
  for (std::uint32_t n = 0; n < reeb().nodes.size(); ++n) {
    if (reeb().nodes[n].instant > 0) nodes.push_back(n);
  }
  std::ranges::stable_sort(nodes, {}, [&](std::uint32_t n) { return reeb().nodes[n].instant; });
  return nodes;
}

std::vector<std::uint32_t> SlabShells::arcsAtEnd() const {
  std::vector<std::uint32_t> arcs;
  for (std::uint32_t a = 0; a < reeb().arcs.size(); ++a) {
    const std::uint32_t above = reeb().arcs[a].above;
    if (above != kNoIndex && reeb().nodes[above].instant == reeb().lastInstant) arcs.push_back(a);
  }
  return arcs;
}

std::vector<Shell> SlabShells::shellsAtEnd(std::vector<std::uint32_t>& owners) const {
  const double begin = instants()[reeb().lastInstant - 1];
  const double time = begin + (instants()[reeb().lastInstant] - begin) / 2;
  const auto surfaces = levelSurfaces(slab_.connectivity->cells, verticesAfter(slab_, time));
  const auto arcs = arcsOf(surfaces, *slab_.connectivity, reeb(), 2 * reeb().lastInstant - 1);
  const auto points = pointsAt(surfaces.cut, slab_.vertices, time);
  const auto measures = measuresOf(surfaces, points, time);
  std::vector<std::uint32_t> shellOf(reeb().arcs.size(), kNoIndex);
  std::vector<Shell> shells;
  for (const std::uint32_t arc : arcsAtEnd()) {
    shellOf[arc] = static_cast<std::uint32_t>(shells.size());
    shells.emplace_back().atFirst = shellOf[arc];
  }
  owners.resize(shells.size());
  std::iota(owners.begin(), owners.end(), 0U);
  std::vector<std::uint32_t> inner;  // surfaces
  for (std::uint32_t s = 0; s < surfaces.count; ++s) {
    if (arcs[s] == kNoIndex || shellOf[arcs[s]] == kNoIndex) continue;
    Shell& shell = shells[shellOf[arcs[s]]];
    shell.euler2 = surfaces.euler2[s];
    shell.outer = measures[s].volume >= 0;
    if (!shell.outer) inner.push_back(s);
  }
  // A ray from a cavity meets other cavities of its solid, or what encloses this.
  const auto next = nextSurfaces(surfaces, points, inner);
  for (std::size_t i = 0; i < inner.size(); ++i) {
    const std::uint32_t hit = next[i] == surfaces.count ? kNoIndex : arcs[next[i]];
    owners[shellOf[arcs[inner[i]]]] = hit == kNoIndex ? kNoIndex : shellOf[hit];
  }
  for (std::uint32_t& owner : owners) {
    std::size_t steps = 0;
    while (owner != kNoIndex && !shells[owner].outer) {
      owner = ++steps > shells.size() ? kNoIndex : owners[owner];
    }
  }
  return shells;
}

/// Measures some arcs of the slab.
void SlabShells::evaluate(const std::vector<std::uint32_t>& wanted) {
  const SlabReeb& reeb = this->reeb();
  const std::vector<double>& instants = this->instants();
  std::vector<ArcInterval> intervals;
  for (const std::uint32_t a : wanted) {
    const auto [below, above] = reeb.arcs[a];
    if (below == kNoIndex || above == kNoIndex || values_.contains(a)) continue;
    intervals.push_back(
        {a, instants[reeb.nodes[below].instant], instants[reeb.nodes[above].instant]});
  }
  for (const double time : piercing(std::move(intervals))) {
    const auto surfaces = levelSurfaces(slab_.connectivity->cells, verticesAfter(slab_, time));
    const auto arcs = arcsOf(surfaces, *slab_.connectivity, reeb, slotAfter(instants, time));
    const auto measures = measuresOf(surfaces, pointsAt(surfaces.cut, slab_.vertices, time), time);
    for (std::uint32_t s = 0; s < surfaces.count; ++s) {
      if (arcs[s] == kNoIndex) continue;
      ArcValue& value = values_[arcs[s]];
      if (std::abs(measures[s].volume) >= std::abs(value.measures.volume)) {
        value = {time, measures[s], surfaces.euler2[s]};
      }
    }
  }
}

/// Whether a surface that appears at a node faces outward. Just after it, it consists of the cells
/// that begin there.
bool SlabShells::birthIsOuter(std::uint32_t node) {
  const SlabReeb& reeb = this->reeb();
  const std::uint32_t instant = reeb.nodes[node].instant;
  std::vector<std::uint32_t> vertices = reeb.nodes[node].vertices;
  for (std::uint32_t i = 0; instant == 0 && i < reeb.nodeOfLower.size(); ++i) {
    if (reeb.nodeOfLower[i] == node) vertices.push_back(i);
  }
  const double time = instants()[instant];
  const auto found = flooding().surfaces(time, cellsAt(vertices), false);
  if (found.empty()) return true;
  return localSurface(slab_, found.front().cells, time).measures.volume >= 0;
}

std::vector<std::uint32_t> SlabShells::cellsAt(std::span<const std::uint32_t> vertices) {
  std::vector<std::uint32_t> cells;
  for (const std::uint32_t vertex : vertices) {
    const auto star = flooding().stars().of(vertex);
    cells.insert(cells.end(), star.begin(), star.end());
  }
  return cells;
}

/// Finds the surfaces into which one splits at a node from all of them but the largest, whose Euler
/// number is what is left. Those that no other holds face as the surface before, those within
/// another the other way: a split solid leaves solids side by side, or one around a cavity; a split
/// cavity leaves cavities side by side, or one around a solid. False if that does not tell.
bool SlabShells::splitLocally(const Transition& one, const std::vector<Shell>& shells,
                              std::vector<Shell>& made) {
  const SlabReeb& reeb = this->reeb();
  if (one.node == kNoIndex || reeb.nodes[one.node].instant == 0 || one.shellsBelow.size() != 1) {
    return false;
  }
  const double time = instants()[reeb.nodes[one.node].instant];
  const std::uint32_t slot = 2 * reeb.nodes[one.node].instant + 1;
  const auto found = flooding().surfaces(time, cellsAt(reeb.nodes[one.node].vertices), true);
  if (found.size() != one.arcsAbove.size()) return false;
  std::unordered_map<std::uint32_t, std::uint32_t> arcOfCell;
  for (const SlabReeb::Stretch& stretch : reeb.stretches) {
    if (stretch.firstSlot > slot || stretch.lastSlot < slot) continue;
    if (std::ranges::find(one.arcsAbove, stretch.arc) == one.arcsAbove.end()) continue;
    arcOfCell[stretch.cell] = stretch.arc;
  }
  const auto arcOf = [&](const FloodedSurface& surface) {
    for (const std::uint32_t cell : surface.cells) {
      for (const std::uint32_t vertex : slab_.connectivity->cells[cell]) {
        if (reeb.slotOfVertex[vertex] == slot) return reeb.arcOfVertex[vertex];
      }
      if (const auto at = arcOfCell.find(cell); at != arcOfCell.end()) return at->second;
    }
    return kNoIndex;
  };
  // The last to be known is that which is not complete, or else any.
  std::size_t last = 0;
  while (last + 1 < found.size() && found[last].complete) ++last;
  std::optional<Point3> place;
  for (const std::uint32_t cell : found[last].cells) {
    for (const std::uint32_t u : slab_.connectivity->cells[cell]) {
      for (const std::uint32_t w : slab_.connectivity->cells[cell]) {
        const model::Point4& a = slab_.vertices[u];
        const model::Point4& b = slab_.vertices[w];
        if (a[3] >= time || b[3] <= time) continue;
        place = a.head<3>() + (time - a[3]) / (b[3] - a[3]) * (b - a).head<3>();
      }
    }
    if (place) break;
  }
  if (!place) return false;
  const Shell& below = shells[one.shellsBelow[0]];
  std::map<std::uint32_t, Shell> ofArc;
  Shell rest;
  rest.euler2 = below.euler2 + one.change2;
  rest.outer = below.outer;
  rest.volume = below.volume;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (i == last) continue;
    const LocalSurface local = localSurface(slab_, found[i].cells, time, &*place);
    Shell shell;
    shell.euler2 = local.euler2;
    shell.outer = local.measures.volume >= 0;
    shell.volume = std::abs(local.measures.volume);
    rest.euler2 -= shell.euler2;
    rest.volume += shell.outer == below.outer ? -shell.volume : shell.volume;
    if (shell.outer == below.outer && local.holdsPlace) rest.outer = !below.outer;
    const std::uint32_t arc = arcOf(found[i]);
    if (arc == kNoIndex || !ofArc.try_emplace(arc, shell).second) return false;
  }
  rest.volume = std::abs(rest.volume);
  for (const std::uint32_t arc : one.arcsAbove) {
    const auto at = ofArc.find(arc);
    made.push_back(at == ofArc.end() ? rest : at->second);
  }
  return ofArc.size() + 1 == one.arcsAbove.size();
}

/// For each of some cavities, just after a time, the surface that bounds its solid, too.
std::vector<std::uint32_t> SlabShells::nextShells(double time,
                                                  const std::vector<std::uint32_t>& inner) const {
  const std::vector<double>& instants = this->instants();
  const std::uint32_t slot = slotAfter(instants, time);
  const double next = instants[(slot + 1) / 2];
  const double between = time + (next - time) / 2;
  const auto surfaces = levelSurfaces(slab_.connectivity->cells, verticesAfter(slab_, between));
  const auto arcs = arcsOf(surfaces, *slab_.connectivity, reeb(), slot);
  std::vector<std::uint32_t> shellOf(surfaces.count, kNoIndex);
  for (std::uint32_t s = 0; s < surfaces.count; ++s) {
    if (arcs[s] != kNoIndex) shellOf[s] = shellOfArc[arcs[s]];
  }
  std::vector<std::uint32_t> found(inner.size(), kNoIndex);
  std::vector<std::uint32_t> asked;
  std::vector<std::size_t> askedFor;
  for (std::size_t i = 0; i < inner.size(); ++i) {
    const auto at = std::ranges::find(shellOf, inner[i]);
    if (at == shellOf.end()) continue;
    asked.push_back(static_cast<std::uint32_t>(at - shellOf.begin()));
    askedFor.push_back(i);
  }
  const auto points = pointsAt(surfaces.cut, slab_.vertices, between);
  const auto hit = nextSurfaces(surfaces, points, asked);
  for (std::size_t i = 0; i < hit.size(); ++i) {
    if (hit[i] < surfaces.count) found[askedFor[i]] = shellOf[hit[i]];
  }
  return found;
}

}  // namespace t4d::measure
