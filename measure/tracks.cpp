#include "measure/tracks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <numeric>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>

#include "measure/derived_track.h"
#include "measure/level_flood.h"
#include "measure/level_surfaces.h"
#include "measure/slab_reeb.h"
#include "model/union_find.h"
#include "t4d/mesh.h"

namespace t4d::measure {
namespace {

using model::kNoIndex;
using model::Point3;

constexpr std::size_t kNoEvent = ~std::size_t{0};

/// What slabs with the same connectivity and the same order of times share.
struct Topology {
  std::shared_ptr<const model::Connectivity> connectivity;
  std::vector<std::uint8_t> ranks;  // of the times of interior vertices
  SlabReeb reeb;
  // The slice just after the lower layer, without triangles that are flat there.
  LevelSurfaces atLower;
  std::vector<std::uint32_t> arcsAtLower;
};

struct Ranks {
  std::vector<std::uint8_t> ofInterior;
  bool exact = true;
};

/// The ranks of the times of interior vertices among them; nothing if there are many. Times that
/// differ by rounding, such as those of means of four and of six vertices, are of one rank.
std::optional<Ranks> ranksOf(const model::Slab& slab) {
  constexpr std::size_t kMost = 16;
  const model::Connectivity& connectivity = *slab.connectivity;
  std::vector<double> times = {slab.timeBegin, slab.timeEnd};
  double last = slab.timeBegin;
  for (std::uint32_t v = connectivity.lowerCount; v < connectivity.firstUpper(); ++v) {
    const double time = slab.vertices[v][3];
    if (time == last) continue;
    last = time;
    if (std::ranges::find(times, time) != times.end()) continue;
    times.push_back(time);
    if (times.size() > kMost) return {};
  }
  std::ranges::sort(times);
  const double rounding = model::kSameTimeUlps * std::numeric_limits<double>::epsilon() *
                          std::max(std::abs(slab.timeBegin), std::abs(slab.timeEnd));
  Ranks ranks;
  std::vector<std::uint8_t> rankOf(times.size(), 0);
  for (std::size_t i = 1; i < times.size(); ++i) {
    const bool apart = times[i] - times[i - 1] > rounding;
    if (!apart && times[i] != times[i - 1]) ranks.exact = false;
    rankOf[i] = static_cast<std::uint8_t>(rankOf[i - 1] + (apart ? 1 : 0));
  }
  ranks.ofInterior.reserve(connectivity.firstUpper() - connectivity.lowerCount);
  for (std::uint32_t v = connectivity.lowerCount; v < connectivity.firstUpper(); ++v) {
    const auto at = std::ranges::lower_bound(times, slab.vertices[v][3]);
    ranks.ofInterior.push_back(rankOf[static_cast<std::size_t>(at - times.begin())]);
  }
  return ranks;
}

/// The surfaces of a slice, by arcs of the slab.
struct ArcMeasures {
  double time = 0;
  std::vector<std::pair<std::uint32_t, SolidMeasures>> ofArcs;
};

struct ArcValue {
  double time = 0;
  SolidMeasures measures;
  std::int64_t euler2 = 0;
};

struct Interval {
  std::uint32_t arc;
  double begin;
  double end;
};

/// As few times as possible, so that each interval has one inside.
std::vector<double> piercing(std::vector<Interval> intervals) {
  std::ranges::sort(intervals, {}, &Interval::end);
  std::vector<double> times;
  for (std::size_t i = 0; i < intervals.size();) {
    const double end = intervals[i].end;
    double begin = intervals[i].begin;
    while (i < intervals.size() && intervals[i].begin < end) {
      begin = std::max(begin, intervals[i++].begin);
    }
    times.push_back(begin + (end - begin) / 2);
    // Those that begin before this time and end later have it inside, too.
    const double time = times.back();
    const auto pierced = [&](const Interval& interval) { return interval.begin < time; };
    intervals.erase(std::remove_if(intervals.begin() + static_cast<std::ptrdiff_t>(i),
                                   intervals.end(), pierced),
                    intervals.end());
  }
  return times;
}

}  // namespace

class Tracker::Impl {
 public:
  Impl(model::TimeSpan time, std::vector<double> sampleTimes, bool surfaces)
      : surfaces_(surfaces), times_(std::move(sampleTimes)) {
    tracks_.time = time;
    std::ranges::sort(times_);
    times_.erase(std::unique(times_.begin(), times_.end()), times_.end());
  }

  struct Measured : Prepared {
    Result<void> sound;
    std::shared_ptr<const Topology> topology;
    std::vector<double> instants;
    std::vector<ArcMeasures> samples;
  };

  std::unique_ptr<Prepared> prepare(const model::Slab& slab) const {
    auto measured = std::make_unique<Measured>();
    if (!slab.connectivity) {
      measured->sound = invalid("has no connectivity");
      return measured;
    }
    const auto known = sharedTopology(slab);
    if (!known) {
      measured->sound = model::checkConnectivity(*slab.connectivity);
      if (!measured->sound) return measured;
    }
    measured->sound = model::checkSlab(slab);
    if (!measured->sound) return measured;
    measured->topology = known ? known : newTopology(slab);
    measured->instants = instantsOf(measured->topology->reeb, slab);
    if (slab.timeBegin == slab.timeEnd) return measured;
    const auto first = std::ranges::lower_bound(times_, slab.timeBegin);
    for (auto at = first; at != times_.end() && *at < slab.timeEnd; ++at) {
      measured->samples.push_back(sample(slab, *measured, *at));
    }
    if (slab.timeEnd == tracks_.time.end && !times_.empty() && times_.back() == slab.timeEnd) {
      measured->samples.push_back(sample(slab, *measured, slab.timeEnd));
    }
    return measured;
  }

  Result<void> put(const model::Slab& slab, const Measured& measured);
  Tracks finish();

 private:
  struct Shell {
    double volume = 0;  // about, at its begin or its last sample
    bool outer = true;
    bool alive = true;
    std::int64_t euler2 = 0;
    std::uint32_t solid = kNoIndex;
    std::size_t appears = kNoEvent;  // of a cavity that began within its solid
    double largestVolume = 0;
  };
  struct Solid {
    std::uint32_t track = 0;
    std::vector<std::uint32_t> shells = {};
  };
  /// A component of the slice at a time, with what it consists of just before and just after.
  struct Transition {
    std::vector<std::uint32_t> shellsBelow = {};
    std::vector<std::uint32_t> arcsAbove = {};
    std::int64_t change2 = 0;
    Point3 placeSum = Point3::Zero();
    double placeCount = 0;
    std::uint32_t node = kNoIndex;  // in the slab, if it has arcs above

    // Found when it is worked on:
    std::vector<std::uint32_t> shellsAbove = {};
    std::vector<std::uint32_t> tracksBefore = {};

    bool isTrivial() const {
      return shellsBelow.size() == 1 && arcsAbove.size() == 1 && change2 == 0;
    }
    Point3 place() const { return placeCount > 0 ? Point3(placeSum / placeCount) : placeSum; }
  };
  /// The slab that is being worked on.
  struct Current {
    const model::Slab* slab;
    const Measured* measured;
    std::vector<std::uint32_t> shellOfArc;
    std::map<std::uint32_t, ArcValue> values;  // of some arcs
    std::shared_ptr<LevelFlood> flood = nullptr;
    const SlabReeb& reeb() const { return measured->topology->reeb; }
    LevelFlood& flooding() {
      if (!flood) flood = std::make_shared<LevelFlood>(*slab);
      return *flood;
    }
  };

  std::shared_ptr<const Topology> sharedTopology(const model::Slab& slab) const;
  std::shared_ptr<const Topology> newTopology(const model::Slab& slab) const;
  ArcMeasures sample(const model::Slab& slab, const Measured& measured, double time) const;

  std::vector<Transition> takeSeam(const model::Slab& slab, const Measured& measured);
  void work(Current* current, double time, std::vector<Transition> transitions);
  void workSurfaces(double time, std::vector<Transition*>& transitions);
  void workSolids(Current* current, double time, std::vector<Transition*>& transitions);
  void makeShells(Current& current, Transition& transition);
  void evaluate(Current& current, const std::vector<std::uint32_t>& wanted) const;
  bool birthIsOuter(Current& current, std::uint32_t node) const;
  static std::vector<std::uint32_t> cellsAt(Current& current,
                                            std::span<const std::uint32_t> vertices);
  bool splitLocally(Current& current, const Transition& one, std::vector<Shell>& made) const;
  std::vector<std::uint32_t> nextShells(Current& current, double time,
                                        const std::vector<std::uint32_t>& inner) const;
  void addDetails(double time, const std::vector<Transition*>& transitions);
  void addSample(const Current& current, const ArcMeasures& sample);
  void addUnsampled(Current& current);
  std::uint32_t addTrack(double time, bool cavity);
  void endTrack(std::uint32_t track, double time);
  bool atStart(double time) const { return time == tracks_.time.begin; }
  bool atEnd(double time) const { return time == tracks_.time.end; }
  std::uint32_t trackOf(std::uint32_t shell) const { return solids_[shells_[shell].solid].track; }
  void addEvent(double time, TrackEventKind kind, const Point3& place,
                std::vector<std::uint32_t> before, std::vector<std::uint32_t> after,
                std::uint64_t count, std::int64_t euler) {
    tracks_.events.push_back(
        {time, kind, place, std::move(before), std::move(after), count, euler});
  }

  bool surfaces_;
  std::vector<double> times_;  // of samples, increasing
  Tracks tracks_;
  std::vector<char> ended_;  // for each track
  std::vector<Shell> shells_;
  std::vector<Solid> solids_;
  // At the last layer: components of the slice there, so far, and those of its vertices.
  double pendingTime_ = 0;
  std::vector<Transition> pending_;
  std::vector<std::uint32_t> pendingOfVertex_;

  mutable std::mutex mutex_;
  mutable std::vector<std::shared_ptr<const Topology>> shared_;
};

std::shared_ptr<const Topology> Tracker::Impl::sharedTopology(const model::Slab& slab) const {
  std::vector<std::shared_ptr<const Topology>> known;
  {
    const std::scoped_lock lock(mutex_);
    for (const auto& one : shared_) {
      if (one->connectivity == slab.connectivity) known.push_back(one);
    }
  }
  if (known.empty() || slab.vertices.size() != slab.connectivity->vertexCount) return nullptr;
  const auto ranks = ranksOf(slab);
  for (const auto& one : known) {
    if (ranks && one->ranks == ranks->ofInterior) return one;
  }
  return nullptr;
}

std::shared_ptr<const Topology> Tracker::Impl::newTopology(const model::Slab& slab) const {
  auto made = std::make_shared<Topology>();
  made->connectivity = slab.connectivity;
  made->reeb = slabReeb(slab);
  if (slab.timeBegin == slab.timeEnd) return made;
  const bool sampled = std::ranges::binary_search(times_, slab.timeBegin);
  auto ranks = ranksOf(slab);
  // Where nothing happens between the layers the order within rounding does not matter.
  if (ranks && !ranks->exact && !made->reeb.between.empty()) ranks.reset();
  if (sampled || ranks) {
    made->atLower = levelSurfaces(slab.connectivity->cells, verticesAfter(slab, slab.timeBegin));
    made->arcsAtLower = arcsOf(made->atLower, *slab.connectivity, made->reeb, 1);
    slice::Cut& cut = made->atLower.cut;
    std::erase_if(cut.triangles, [&](const model::Triangle& triangle) {
      const auto at = [&](int i) { return cut.points[triangle[i]].below; };
      return at(0) == at(1) || at(1) == at(2) || at(2) == at(0);
    });
    cut.cells.clear();
  }
  if (!ranks) return made;
  made->ranks = std::move(ranks->ofInterior);
  // Of two at most, which alternate where a motion does.
  constexpr std::size_t kMost = 2;
  const std::scoped_lock lock(mutex_);
  if (shared_.size() == kMost) shared_.erase(shared_.begin());
  shared_.push_back(made);
  return made;
}

ArcMeasures Tracker::Impl::sample(const model::Slab& slab, const Measured& measured,
                                  double time) const {
  const Topology& topology = *measured.topology;
  ArcMeasures sample{time, {}};
  const auto add = [&](const LevelSurfaces& surfaces, const std::vector<std::uint32_t>& arcs) {
    const auto measures = measuresOf(surfaces, pointsAt(surfaces.cut, slab.vertices, time), time);
    for (std::uint32_t s = 0; s < surfaces.count; ++s) {
      if (arcs[s] != kNoIndex) sample.ofArcs.emplace_back(arcs[s], measures[s]);
    }
  };
  if (time == slab.timeBegin) {
    add(topology.atLower, topology.arcsAtLower);
    return sample;
  }
  const bool end = time == slab.timeEnd;
  const auto surfaces = levelSurfaces(slab.connectivity->cells, verticesAfter(slab, time, end));
  const std::uint32_t slot =
      end ? 2 * topology.reeb.lastInstant - 1 : slotAfter(measured.instants, time);
  add(surfaces, arcsOf(surfaces, *slab.connectivity, topology.reeb, slot));
  return sample;
}

/// Joins the components at the first time of the slab with those that are pending.
std::vector<Tracker::Impl::Transition> Tracker::Impl::takeSeam(const model::Slab& slab,
                                                               const Measured& measured) {
  const SlabReeb& reeb = measured.topology->reeb;
  const auto waiting = static_cast<std::uint32_t>(pending_.size());
  std::vector<std::uint32_t> nodes;  // of the first instant
  std::vector<std::uint32_t> itemOfNode(reeb.nodes.size(), kNoIndex);
  for (std::uint32_t n = 0; n < reeb.nodes.size(); ++n) {
    if (reeb.nodes[n].instant != 0) continue;
    itemOfNode[n] = waiting + static_cast<std::uint32_t>(nodes.size());
    nodes.push_back(n);
  }
  model::UnionFind sets(waiting + nodes.size());
  const std::size_t seam = std::min(pendingOfVertex_.size(), reeb.nodeOfLower.size());
  for (std::size_t i = 0; i < seam; ++i) {
    const std::uint32_t node = reeb.nodeOfLower[i];
    if (pendingOfVertex_[i] != kNoIndex && node != kNoIndex) {
      sets.unite(pendingOfVertex_[i], itemOfNode[node]);
    }
  }
  std::vector<Transition> joined;
  std::vector<std::uint32_t> number(waiting + nodes.size());
  for (std::uint32_t i = 0; i < number.size(); ++i) {
    const std::uint32_t root = sets.root(i);
    number[i] = root == i ? static_cast<std::uint32_t>(joined.size()) : number[root];
    if (root == i) joined.emplace_back();
    Transition& into = joined[number[i]];
    if (i < waiting) {
      const Transition& from = pending_[i];
      into.shellsBelow.insert(into.shellsBelow.end(), from.shellsBelow.begin(),
                              from.shellsBelow.end());
      into.change2 += from.change2;
      into.placeSum += from.placeSum;
      into.placeCount += from.placeCount;
    } else {
      const std::uint32_t node = nodes[i - waiting];
      into.change2 += reeb.nodes[node].eulerChange2;
      into.node = node;
    }
  }
  for (std::uint32_t a = 0; a < reeb.arcs.size(); ++a) {
    const std::uint32_t node = reeb.arcs[a].below;
    if (node != kNoIndex && itemOfNode[node] != kNoIndex) {
      joined[number[itemOfNode[node]]].arcsAbove.push_back(a);
    }
  }
  // The places of vertices of this layer that no slab before has given.
  for (std::size_t i = 0; i < reeb.nodeOfLower.size(); ++i) {
    const std::uint32_t node = reeb.nodeOfLower[i];
    if (node == kNoIndex || (i < seam && pendingOfVertex_[i] != kNoIndex)) continue;
    Transition& into = joined[number[itemOfNode[node]]];
    into.placeSum += slab.vertices[i].head<3>();
    ++into.placeCount;
  }
  pending_.clear();
  pendingOfVertex_.clear();
  if (slab.timeBegin < slab.timeEnd) return joined;
  // Nothing goes on before a slab that has a duration.
  pendingOfVertex_.assign(reeb.nodeOfUpper.size(), kNoIndex);
  for (std::size_t i = 0; i < reeb.nodeOfUpper.size(); ++i) {
    const std::uint32_t node = reeb.nodeOfUpper[i];
    if (node == kNoIndex) continue;
    pendingOfVertex_[i] = number[itemOfNode[node]];
    if (!reeb.nodeOfLower.empty()) continue;
    Transition& into = joined[pendingOfVertex_[i]];
    into.placeSum += slab.upperLayer()[i].head<3>();
    ++into.placeCount;
  }
  pending_ = std::move(joined);
  return {};
}

Result<void> Tracker::Impl::put(const model::Slab& slab, const Measured& measured) {
  if (!measured.sound) return measured.sound.error();
  if (slab.timeBegin > pendingTime_ && !pending_.empty()) {
    // A gap in time, before which everything has ended.
    work(nullptr, pendingTime_, std::exchange(pending_, {}));
    pendingOfVertex_.clear();
  }
  std::vector<Transition> transitions = takeSeam(slab, measured);
  pendingTime_ = slab.timeEnd;
  if (slab.timeBegin == slab.timeEnd) return {};
  const SlabReeb& reeb = measured.topology->reeb;
  Current current{&slab, &measured, std::vector<std::uint32_t>(reeb.arcs.size(), kNoIndex), {}};
  auto sample = measured.samples.begin();
  const auto addSamples = [&](double before) {
    for (; sample != measured.samples.end() && sample->time < before; ++sample) {
      addSample(current, *sample);
    }
  };
  work(&current, slab.timeBegin, std::move(transitions));

  // The arcs below and above each interior node.
  std::vector<Transition> ofNodes(reeb.nodes.size());
  std::vector<std::vector<std::uint32_t>> arcsBelow(reeb.nodes.size());
  for (std::uint32_t a = 0; a < reeb.arcs.size(); ++a) {
    const auto [below, above] = reeb.arcs[a];
    if (below != kNoIndex && reeb.nodes[below].instant > 0) ofNodes[below].arcsAbove.push_back(a);
    if (above != kNoIndex) arcsBelow[above].push_back(a);
  }
  std::vector<std::uint32_t> order;
  for (std::uint32_t n = 0; n < reeb.nodes.size(); ++n) {
    if (reeb.nodes[n].instant > 0) order.push_back(n);
  }
  std::ranges::stable_sort(order, {}, [&](std::uint32_t n) { return reeb.nodes[n].instant; });
  for (std::size_t i = 0; i < order.size();) {
    const std::uint32_t instant = reeb.nodes[order[i]].instant;
    const bool last = instant == reeb.lastInstant;
    if (!last) addSamples(measured.instants[instant]);
    std::vector<Transition> together;
    const std::size_t begin = i;
    for (; i < order.size() && reeb.nodes[order[i]].instant == instant; ++i) {
      Transition& one = ofNodes[order[i]];
      const SlabReeb::Node& node = reeb.nodes[order[i]];
      one.change2 = node.eulerChange2;
      one.node = order[i];
      for (const std::uint32_t arc : arcsBelow[order[i]]) {
        if (current.shellOfArc[arc] != kNoIndex) {
          one.shellsBelow.push_back(current.shellOfArc[arc]);
        }
      }
      for (const std::uint32_t vertex : node.vertices) {
        one.placeSum += slab.vertices[vertex].head<3>();
        ++one.placeCount;
      }
      together.push_back(std::move(one));
    }
    if (!last) {
      work(&current, measured.instants[instant], std::move(together));
      continue;
    }
    addSamples(std::numeric_limits<double>::infinity());
    std::vector<std::uint32_t> numberOf(reeb.nodes.size(), kNoIndex);
    for (std::size_t k = begin; k < i; ++k) {
      numberOf[order[k]] = static_cast<std::uint32_t>(k - begin);
    }
    pending_ = std::move(together);
    pendingOfVertex_.assign(reeb.nodeOfUpper.size(), kNoIndex);
    for (std::size_t k = 0; k < reeb.nodeOfUpper.size(); ++k) {
      const std::uint32_t node = reeb.nodeOfUpper[k];
      if (node == kNoIndex) continue;
      Transition& into = pending_[numberOf[node]];
      pendingOfVertex_[k] = numberOf[node];
      into.placeSum += slab.upperLayer()[k].head<3>();
      ++into.placeCount;
    }
  }
  addSamples(std::numeric_limits<double>::infinity());
  addUnsampled(current);
  return {};
}

Tracks Tracker::Impl::finish() {
  work(nullptr, pendingTime_, std::exchange(pending_, {}));
  setSpeeds(tracks_);
  return std::move(tracks_);
}

std::uint32_t Tracker::Impl::addTrack(double time, bool cavity) {
  Track track;
  track.begin = track.end = time;
  track.beginsWithMesh = atStart(time);
  track.cavity = cavity;
  tracks_.tracks.push_back(std::move(track));
  ended_.push_back(0);
  return static_cast<std::uint32_t>(tracks_.tracks.size() - 1);
}

void Tracker::Impl::endTrack(std::uint32_t track, double time) {
  ended_[track] = 1;
  tracks_.tracks[track].end = time;
  tracks_.tracks[track].endsWithMesh = atEnd(time);
}

/// Everything that happens at one time.
void Tracker::Impl::work(Current* current, double time, std::vector<Transition> transitions) {
  std::vector<Transition*> real;
  for (Transition& one : transitions) {
    if (one.isTrivial()) {
      current->shellOfArc[one.arcsAbove[0]] = one.shellsBelow[0];
    } else if (!one.shellsBelow.empty() || !one.arcsAbove.empty()) {
      real.push_back(&one);
    }
  }
  for (Transition* one : real) {
    for (const std::uint32_t shell : one->shellsBelow) {
      const std::uint32_t track = trackOf(shell);
      if (std::ranges::find(one->tracksBefore, track) == one->tracksBefore.end()) {
        one->tracksBefore.push_back(track);
      }
    }
    if (one->shellsBelow.size() == 1 && one->arcsAbove.size() == 1) {
      Shell& shell = shells_[one->shellsBelow[0]];
      shell.euler2 += one->change2;
      one->shellsAbove = one->shellsBelow;
      current->shellOfArc[one->arcsAbove[0]] = one->shellsBelow[0];
      continue;
    }
    if (!one->arcsAbove.empty()) makeShells(*current, *one);
  }
  if (surfaces_) {
    workSurfaces(time, real);
  } else {
    workSolids(current, time, real);
  }
  if (!atStart(time) && !atEnd(time)) addDetails(time, real);
}

/// Adds the surfaces above a transition, with their Euler numbers and whether they face outward.
void Tracker::Impl::makeShells(Current& current, Transition& one) {
  std::optional<bool> outer;
  if (one.arcsAbove.size() == 1) {
    const auto isOuter = [&](std::uint32_t shell) { return shells_[shell].outer; };
    const auto outers = std::ranges::count_if(one.shellsBelow, isOuter);
    if (one.shellsBelow.empty() && one.node != kNoIndex) {
      outer = birthIsOuter(current, one.node);
    } else if (outers == 0 || outers == std::ssize(one.shellsBelow)) {
      // What merges outside is one outside, what merges within a solid is one cavity.
      outer = outers != 0;
    } else if (one.shellsBelow.size() == 2 && !surfaces_) {
      // A cavity opens to the outside, or a solid within a cavity reaches its wall.
      outer = shells_[one.shellsBelow[0]].solid == shells_[one.shellsBelow[1]].solid;
    }
  }
  std::vector<Shell> made;
  if (outer) {
    Shell shell;
    shell.outer = *outer;
    shell.euler2 = one.change2;
    for (const std::uint32_t below : one.shellsBelow) {
      shell.euler2 += shells_[below].euler2;
      shell.volume += shells_[below].volume;
    }
    made.push_back(shell);
  } else if (!splitLocally(current, one, made)) {
    made.clear();
    evaluate(current, one.arcsAbove);
    for (const std::uint32_t arc : one.arcsAbove) {
      const ArcValue& value = current.values[arc];
      Shell shell;
      shell.outer = value.measures.volume >= 0;
      shell.euler2 = value.euler2;
      shell.volume = std::abs(value.measures.volume);
      made.push_back(shell);
    }
  }
  for (std::size_t i = 0; i < made.size(); ++i) {
    current.shellOfArc[one.arcsAbove[i]] = static_cast<std::uint32_t>(shells_.size());
    one.shellsAbove.push_back(static_cast<std::uint32_t>(shells_.size()));
    shells_.push_back(made[i]);
  }
}

/// Measures some arcs of the slab.
void Tracker::Impl::evaluate(Current& current, const std::vector<std::uint32_t>& wanted) const {
  const SlabReeb& reeb = current.reeb();
  const std::vector<double>& instants = current.measured->instants;
  std::vector<Interval> intervals;
  for (const std::uint32_t a : wanted) {
    const auto [below, above] = reeb.arcs[a];
    if (below == kNoIndex || above == kNoIndex || current.values.contains(a)) continue;
    intervals.push_back(
        {a, instants[reeb.nodes[below].instant], instants[reeb.nodes[above].instant]});
  }
  for (const double time : piercing(std::move(intervals))) {
    const auto surfaces =
        levelSurfaces(current.slab->connectivity->cells, verticesAfter(*current.slab, time));
    const auto arcs =
        arcsOf(surfaces, *current.slab->connectivity, reeb, slotAfter(instants, time));
    const auto measures =
        measuresOf(surfaces, pointsAt(surfaces.cut, current.slab->vertices, time), time);
    for (std::uint32_t s = 0; s < surfaces.count; ++s) {
      if (arcs[s] == kNoIndex) continue;
      ArcValue& value = current.values[arcs[s]];
      if (std::abs(measures[s].volume) >= std::abs(value.measures.volume)) {
        value = {time, measures[s], surfaces.euler2[s]};
      }
    }
  }
}

/// Whether a surface that appears at a node faces outward. Just after it, it consists of the cells
/// that begin there.
bool Tracker::Impl::birthIsOuter(Current& current, std::uint32_t node) const {
  const SlabReeb& reeb = current.reeb();
  const std::uint32_t instant = reeb.nodes[node].instant;
  std::vector<std::uint32_t> vertices = reeb.nodes[node].vertices;
  for (std::uint32_t i = 0; instant == 0 && i < reeb.nodeOfLower.size(); ++i) {
    if (reeb.nodeOfLower[i] == node) vertices.push_back(i);
  }
  const double time = current.measured->instants[instant];
  const auto found = current.flooding().surfaces(time, cellsAt(current, vertices), false);
  if (found.empty()) return true;
  return localSurface(*current.slab, found.front().cells, time).measures.volume >= 0;
}

std::vector<std::uint32_t> Tracker::Impl::cellsAt(Current& current,
                                                  std::span<const std::uint32_t> vertices) {
  std::vector<std::uint32_t> cells;
  for (const std::uint32_t vertex : vertices) {
    const auto star = current.flooding().stars().of(vertex);
    cells.insert(cells.end(), star.begin(), star.end());
  }
  return cells;
}

/// Finds the surfaces into which one splits at a node from all of them but the largest, whose Euler
/// number is what is left. Those that no other holds face as the surface before, those within
/// another the other way: a split solid leaves solids side by side, or one around a cavity; a split
/// cavity leaves cavities side by side, or one around a solid. False if that does not tell.
bool Tracker::Impl::splitLocally(Current& current, const Transition& one,
                                 std::vector<Shell>& made) const {
  const SlabReeb& reeb = current.reeb();
  if (one.node == kNoIndex || reeb.nodes[one.node].instant == 0 || one.shellsBelow.size() != 1) {
    return false;
  }
  const double time = current.measured->instants[reeb.nodes[one.node].instant];
  const std::uint32_t slot = 2 * reeb.nodes[one.node].instant + 1;
  const auto found =
      current.flooding().surfaces(time, cellsAt(current, reeb.nodes[one.node].vertices), true);
  if (found.size() != one.arcsAbove.size()) return false;
  std::unordered_map<std::uint32_t, std::uint32_t> arcOfCell;
  for (const SlabReeb::Stretch& stretch : reeb.stretches) {
    if (stretch.firstSlot > slot || stretch.lastSlot < slot) continue;
    if (std::ranges::find(one.arcsAbove, stretch.arc) == one.arcsAbove.end()) continue;
    arcOfCell[stretch.cell] = stretch.arc;
  }
  const auto arcOf = [&](const FloodedSurface& surface) {
    for (const std::uint32_t cell : surface.cells) {
      for (const std::uint32_t vertex : current.slab->connectivity->cells[cell]) {
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
    for (const std::uint32_t u : current.slab->connectivity->cells[cell]) {
      for (const std::uint32_t w : current.slab->connectivity->cells[cell]) {
        const model::Point4& a = current.slab->vertices[u];
        const model::Point4& b = current.slab->vertices[w];
        if (a[3] >= time || b[3] <= time) continue;
        place = a.head<3>() + (time - a[3]) / (b[3] - a[3]) * (b - a).head<3>();
      }
    }
    if (place) break;
  }
  if (!place) return false;
  const Shell& below = shells_[one.shellsBelow[0]];
  std::map<std::uint32_t, Shell> ofArc;
  Shell rest;
  rest.euler2 = below.euler2 + one.change2;
  rest.outer = below.outer;
  rest.volume = below.volume;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (i == last) continue;
    const LocalSurface local = localSurface(*current.slab, found[i].cells, time, &*place);
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
std::vector<std::uint32_t> Tracker::Impl::nextShells(
    Current& current, double time, const std::vector<std::uint32_t>& inner) const {
  const std::vector<double>& instants = current.measured->instants;
  const std::uint32_t slot = slotAfter(instants, time);
  const double next = instants[(slot + 1) / 2];
  const double between = time + (next - time) / 2;
  const auto surfaces =
      levelSurfaces(current.slab->connectivity->cells, verticesAfter(*current.slab, between));
  const auto arcs = arcsOf(surfaces, *current.slab->connectivity, current.reeb(), slot);
  std::vector<std::uint32_t> shellOf(surfaces.count, kNoIndex);
  for (std::uint32_t s = 0; s < surfaces.count; ++s) {
    if (arcs[s] != kNoIndex) shellOf[s] = current.shellOfArc[arcs[s]];
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
  const auto points = pointsAt(surfaces.cut, current.slab->vertices, between);
  const auto hit = nextSurfaces(surfaces, points, asked);
  for (std::size_t i = 0; i < hit.size(); ++i) {
    if (hit[i] < surfaces.count) found[askedFor[i]] = shellOf[hit[i]];
  }
  return found;
}

/// Every surface is a track of its own.
void Tracker::Impl::workSurfaces(double time, std::vector<Transition*>& transitions) {
  for (Transition* one : transitions) {
    if (one->shellsBelow == one->shellsAbove) continue;
    std::vector<std::uint32_t> after;
    for (const std::uint32_t shell : one->shellsAbove) {
      shells_[shell].solid = static_cast<std::uint32_t>(solids_.size());
      after.push_back(addTrack(time, !shells_[shell].outer));
      solids_.push_back({after.back(), {shell}});
    }
    const std::vector<std::uint32_t>& before = one->tracksBefore;
    for (const std::uint32_t track : before) {
      endTrack(track, time);
      tracks_.tracks[track].into = after;
    }
    for (const std::uint32_t track : after) tracks_.tracks[track].from = before;
    if (atStart(time) || atEnd(time)) continue;
    const std::int64_t shells = std::ssize(after) - std::ssize(before);
    addEvent(time, trackKindOf(before.size(), after.size()), one->place(), before, after,
             trackCountOf(before.size(), after.size()),
             before.empty() || after.empty() ? one->change2 / 2 : 2 * shells);
  }
}

/// Finds which solids go on as which, and whose the cavities are.
void Tracker::Impl::workSolids(Current* current, double time,
                               std::vector<Transition*>& transitions) {
  // Items: solids that take part, transitions, outward surfaces afterwards.
  std::vector<std::uint32_t> touched;
  std::unordered_map<std::uint32_t, std::uint32_t> itemOfSolid;
  for (const Transition* one : transitions) {
    for (const std::uint32_t shell : one->shellsBelow) {
      const std::uint32_t solid = shells_[shell].solid;
      if (itemOfSolid.try_emplace(solid, static_cast<std::uint32_t>(touched.size())).second) {
        touched.push_back(solid);
      }
    }
    if (one->shellsBelow == one->shellsAbove) continue;
    for (const std::uint32_t shell : one->shellsBelow) shells_[shell].alive = false;
  }
  const auto firstTransition = static_cast<std::uint32_t>(touched.size());
  const auto firstOuter = firstTransition + static_cast<std::uint32_t>(transitions.size());
  struct Outer {
    std::uint32_t shell;
    std::uint32_t with;  // item
  };
  std::vector<Outer> outers;
  std::vector<Outer> inners;
  const auto addShell = [&](std::uint32_t shell, std::uint32_t with) {
    (shells_[shell].outer ? outers : inners).push_back({shell, with});
  };
  for (std::uint32_t i = 0; i < touched.size(); ++i) {
    for (const std::uint32_t shell : solids_[touched[i]].shells) {
      if (shells_[shell].alive) addShell(shell, i);
    }
  }
  for (std::uint32_t t = 0; t < transitions.size(); ++t) {
    const Transition& one = *transitions[t];
    if (one.shellsBelow == one.shellsAbove) continue;
    for (const std::uint32_t shell : one.shellsAbove) addShell(shell, firstTransition + t);
  }
  model::UnionFind sets(firstOuter + outers.size());
  for (std::uint32_t t = 0; t < transitions.size(); ++t) {
    for (const std::uint32_t shell : transitions[t]->shellsBelow) {
      sets.unite(firstTransition + t, itemOfSolid[shells_[shell].solid]);
    }
  }
  for (std::uint32_t o = 0; o < outers.size(); ++o) sets.unite(firstOuter + o, outers[o].with);

  // Of a class with one outward surface all cavities are in it; those of others are looked for.
  std::vector<std::uint32_t> outerCount(firstOuter + outers.size(), 0);
  std::vector<std::uint32_t> soleOuter(firstOuter + outers.size(), kNoIndex);
  std::unordered_map<std::uint32_t, std::uint32_t> outerOfShell;
  for (std::uint32_t o = 0; o < outers.size(); ++o) {
    ++outerCount[sets.root(firstOuter + o)];
    soleOuter[sets.root(firstOuter + o)] = o;
    outerOfShell[outers[o].shell] = o;
  }
  std::vector<std::vector<std::uint32_t>> cavitiesOf(outers.size());
  std::vector<std::uint32_t> unknown;
  std::unordered_map<std::uint32_t, std::uint32_t> ownerOf;  // of a cavity, the outward surface
  for (const Outer& inner : inners) {
    const std::uint32_t root = sets.root(inner.with);
    if (outerCount[root] == 1) {
      ownerOf[inner.shell] = outers[soleOuter[root]].shell;
    } else {
      unknown.push_back(inner.shell);
    }
  }
  if (!unknown.empty() && current != nullptr) {
    const auto next = nextShells(*current, time, unknown);
    std::unordered_map<std::uint32_t, std::uint32_t> nextOf;
    for (std::size_t i = 0; i < unknown.size(); ++i) nextOf[unknown[i]] = next[i];
    for (const std::uint32_t shell : unknown) {
      std::uint32_t at = shell;
      // From cavity to cavity of one solid; each is farther along the ray's direction.
      for (std::size_t steps = 0; steps <= unknown.size() && at != kNoIndex; ++steps) {
        if (shells_[at].outer || ownerOf.contains(at) || !nextOf.contains(at)) break;
        at = nextOf[at];
      }
      if (at == kNoIndex) continue;
      if (shells_[at].outer) {
        ownerOf[shell] = at;
      } else if (const auto known = ownerOf.find(at); known != ownerOf.end()) {
        ownerOf[shell] = known->second;
      } else if (shells_[at].solid != kNoIndex && at != shell) {
        // A cavity of a solid that takes no part.
        for (const std::uint32_t of : solids_[shells_[at].solid].shells) {
          if (shells_[of].outer) ownerOf[shell] = of;
        }
      }
    }
  }
  for (const Outer& inner : inners) {
    const auto owner = ownerOf.find(inner.shell);
    // A mesh that is inside out somewhere: the cavity is taken for a solid of its own.
    if (owner == ownerOf.end()) {
      shells_[inner.shell].solid = static_cast<std::uint32_t>(solids_.size());
      solids_.push_back({addTrack(time, true), {inner.shell}});
      continue;
    }
    if (const auto candidate = outerOfShell.find(owner->second); candidate != outerOfShell.end()) {
      cavitiesOf[candidate->second].push_back(inner.shell);
    } else {
      const std::uint32_t solid = shells_[owner->second].solid;
      shells_[inner.shell].solid = solid;
      solids_[solid].shells.push_back(inner.shell);
    }
  }

  struct Class {
    std::vector<std::uint32_t> before;  // solids
    std::vector<std::uint32_t> after;   // outers
    std::vector<std::uint32_t> transitions;
  };
  std::map<std::uint32_t, Class> classes;
  for (std::uint32_t i = 0; i < touched.size(); ++i) {
    classes[sets.root(i)].before.push_back(touched[i]);
  }
  for (std::uint32_t o = 0; o < outers.size(); ++o) {
    classes[sets.root(firstOuter + o)].after.push_back(o);
  }
  for (std::uint32_t t = 0; t < transitions.size(); ++t) {
    classes[sets.root(firstTransition + t)].transitions.push_back(t);
  }
  for (const auto& [root, one] : classes) {
    const auto keep = [&](std::uint32_t solid, std::uint32_t o) {
      solids_[solid].shells = {outers[o].shell};
      auto& shells = solids_[solid].shells;
      shells.insert(shells.end(), cavitiesOf[o].begin(), cavitiesOf[o].end());
      for (const std::uint32_t shell : shells) shells_[shell].solid = solid;
    };
    if (one.before.size() == 1 && one.after.size() == 1) {
      keep(one.before[0], one.after[0]);
      continue;
    }
    if (one.before.empty() && one.after.empty()) continue;  // a cavity in a solid
    std::vector<std::uint32_t> before;
    std::vector<std::uint32_t> after;
    for (const std::uint32_t solid : one.before) before.push_back(solids_[solid].track);
    for (const std::uint32_t o : one.after) {
      after.push_back(addTrack(time, false));
      solids_.push_back({after.back(), {}});
      keep(static_cast<std::uint32_t>(solids_.size() - 1), o);
    }
    for (const std::uint32_t solid : one.before) {
      endTrack(solids_[solid].track, time);
      solids_[solid].shells = {};
    }
    if (atStart(time) || atEnd(time)) continue;
    for (const std::uint32_t track : before) tracks_.tracks[track].into = after;
    for (const std::uint32_t track : after) tracks_.tracks[track].from = before;
    // Cavities have events of their own.
    std::int64_t euler = 0;
    Point3 place = Point3::Zero();
    for (const std::uint32_t t : one.transitions) {
      const Transition& part = *transitions[t];
      place += part.place() / static_cast<double>(one.transitions.size());
      if (part.shellsBelow == part.shellsAbove) continue;
      const auto isOuter = [&](std::uint32_t shell) { return shells_[shell].outer; };
      const std::int64_t outerChange = std::ranges::count_if(part.shellsAbove, isOuter) -
                                       std::ranges::count_if(part.shellsBelow, isOuter);
      const std::int64_t innerChange =
          std::ssize(part.shellsAbove) - std::ssize(part.shellsBelow) - outerChange;
      const bool alone = part.shellsBelow.empty() || part.shellsAbove.empty();
      if (alone && outerChange == 0) continue;  // a cavity that vanishes with its solid
      euler += alone ? part.change2 / 2 - 2 * innerChange : 2 * outerChange;
    }
    addEvent(time, trackKindOf(before.size(), after.size()), place, before, after,
             trackCountOf(before.size(), after.size()), euler);
  }
}

/// Adds the events of holes and cavities.
void Tracker::Impl::addDetails(double time, const std::vector<Transition*>& transitions) {
  for (const Transition* one : transitions) {
    std::vector<std::uint32_t> after;
    for (const std::uint32_t shell : one->shellsAbove) {
      const std::uint32_t track = trackOf(shell);
      if (std::ranges::find(after, track) == after.end()) after.push_back(track);
    }
    const auto isOuter = [&](std::uint32_t shell) { return shells_[shell].outer; };
    const std::int64_t outersBelow = std::ranges::count_if(one->shellsBelow, isOuter);
    const std::int64_t outersAbove = std::ranges::count_if(one->shellsAbove, isOuter);
    const std::int64_t innersBelow = std::ssize(one->shellsBelow) - outersBelow;
    const std::int64_t innersAbove = std::ssize(one->shellsAbove) - outersAbove;
    const bool alone = one->shellsBelow.empty() || one->shellsAbove.empty();
    if (!surfaces_ && innersBelow != innersAbove) {
      using enum TrackEventKind;
      const bool more = innersAbove > innersBelow;
      TrackEventKind kind = more ? CavityCloses : CavityOpens;
      if (outersBelow == 0 && outersAbove == 0) kind = more ? CavitiesSplit : CavitiesMerge;
      if (one->shellsBelow.empty()) kind = CavityAppears;
      if (one->shellsAbove.empty()) kind = CavityVanishes;
      const bool only = alone && outersBelow + outersAbove == 0;
      // Those of a cavity alone are of its solid, which goes on.
      const auto& others = one->tracksBefore.empty() ? after : one->tracksBefore;
      addEvent(time, kind, one->place(), others, after.empty() ? others : after,
               static_cast<std::uint64_t>(std::abs(innersAbove - innersBelow)),
               only ? one->change2 / 2 : 2 * (innersAbove - innersBelow));
    }
    if (!surfaces_ && outersBelow + outersAbove == 0) {
      for (const std::uint32_t shell : one->shellsAbove) {
        if (innersBelow == 0) shells_[shell].appears = tracks_.events.size() - 1;
      }
      if (innersAbove == 0 && innersBelow == 1) {
        const Shell& shell = shells_[one->shellsBelow[0]];
        if (shell.appears != kNoEvent) {
          tracks_.briefCavities.push_back(
              {shell.appears, tracks_.events.size() - 1, shell.largestVolume});
        }
      }
    }
    if (alone) continue;
    const std::int64_t handles =
        std::ssize(one->shellsAbove) - std::ssize(one->shellsBelow) - one->change2 / 4;
    if (handles == 0) continue;
    addEvent(time, handles > 0 ? TrackEventKind::HoleOpens : TrackEventKind::HoleCloses,
             one->place(), one->tracksBefore, after, static_cast<std::uint64_t>(std::abs(handles)),
             -2 * handles);
  }
}

void Tracker::Impl::addSample(const Current& current, const ArcMeasures& sample) {
  std::map<std::uint32_t, SolidMeasures> ofTracks;
  for (const auto& [arc, measures] : sample.ofArcs) {
    const std::uint32_t shell = current.shellOfArc[arc];
    if (shell == kNoIndex) continue;
    shells_[shell].volume = std::abs(measures.volume);
    shells_[shell].largestVolume = std::max(shells_[shell].largestVolume, shells_[shell].volume);
    SolidMeasures one = measures;
    one.components = shells_[shell].outer ? 1 : 0;
    one.cavities = 1 - one.components;
    one.genus = 1 - static_cast<double>(shells_[shell].euler2) / 4;
    SolidMeasures& sum = ofTracks[trackOf(shell)];
    sum.add(one);
    sum.time = sample.time;
  }
  for (const auto& [number, measures] : ofTracks) {
    Track& track = tracks_.tracks[number];
    track.largestVolume = std::max(track.largestVolume, std::abs(measures.volume));
    track.samples.push_back({measures});
  }
}

/// Gives tracks that are not measured while they exist, as far as is known, a volume: that at their
/// begin or, of those that appear, at the vertex of this slab next to the middle of their time.
void Tracker::Impl::addUnsampled(Current& current) {
  const bool atNext = std::ranges::binary_search(times_, current.slab->timeEnd);
  const SlabReeb& reeb = current.reeb();
  struct Middle {
    double time;
    std::uint32_t vertex = kNoIndex;
  };
  std::map<std::uint32_t, Middle> ofArcs;
  for (std::uint32_t a = 0; a < reeb.arcs.size(); ++a) {
    const std::uint32_t shell = current.shellOfArc[a];
    if (shell == kNoIndex || (!surfaces_ && !shells_[shell].outer)) continue;
    const std::uint32_t number = trackOf(shell);
    Track& track = tracks_.tracks[number];
    if (!track.samples.empty() || track.begin < current.slab->timeBegin) continue;
    if (ended_[number] == 0 && atNext) continue;
    track.largestVolume = std::max(track.largestVolume, shells_[shell].volume);
    if (track.largestVolume > 0) continue;
    const double end = ended_[number] != 0 ? track.end : current.slab->timeEnd;
    ofArcs[a] = {track.begin + (end - track.begin) / 2};
  }
  if (ofArcs.empty()) return;
  for (std::uint32_t v = 0; v < reeb.arcOfVertex.size(); ++v) {
    if (reeb.arcOfVertex[v] == kNoIndex) continue;
    const auto at = ofArcs.find(reeb.arcOfVertex[v]);
    if (at == ofArcs.end()) continue;
    const auto distance = [&](std::uint32_t vertex) {
      return std::abs(current.slab->vertices[vertex][3] - at->second.time);
    };
    std::uint32_t& best = at->second.vertex;
    if (best == kNoIndex || distance(v) < distance(best)) best = v;
  }
  for (const SlabReeb::Stretch& stretch : reeb.stretches) {
    const auto at = ofArcs.find(stretch.arc);
    if (at == ofArcs.end()) continue;
    // Without a vertex all cells last from instant to instant.
    const std::uint32_t vertex = at->second.vertex;
    const std::uint32_t instant = stretch.firstSlot / 2;
    const std::vector<double>& instants = current.measured->instants;
    const double time = vertex != kNoIndex ? current.slab->vertices[vertex][3]
                                           : (instants[instant] + instants[instant + 1]) / 2;
    const std::uint32_t cell = stretch.cell;
    const auto star = vertex != kNoIndex ? current.flooding().stars().of(vertex)
                                         : std::span<const std::uint32_t>(&cell, 1);
    const auto found = current.flooding().surfaces(time, star, false);
    Track& track = tracks_.tracks[trackOf(current.shellOfArc[stretch.arc])];
    if (!found.empty()) {
      const double volume = localSurface(*current.slab, found.front().cells, time).measures.volume;
      track.largestVolume = std::max(track.largestVolume, std::abs(volume));
    }
    ofArcs.erase(at);
  }
}

Tracker::Tracker(model::TimeSpan time, std::vector<double> sampleTimes, bool surfaces)
    : impl_(std::make_unique<Impl>(time, std::move(sampleTimes), surfaces)) {}
Tracker::~Tracker() = default;

Result<void> Tracker::put(const model::Slab& slab) {
  return putPrepared(slab, prepare(slab).get());
}
std::unique_ptr<model::Sink::Prepared> Tracker::prepare(const model::Slab& slab) const {
  return impl_->prepare(slab);
}
Result<void> Tracker::putPrepared(const model::Slab& slab, Prepared* prepared) {
  return impl_->put(slab, static_cast<const Impl::Measured&>(*prepared));
}
Tracks Tracker::finish() { return impl_->finish(); }

Result<Tracks> tracksOf(const model::Source& source, const TrackOptions& options,
                        const model::Progress& progress) {
  const model::TimeSpan span = model::timeSpanOf(source);
  std::vector<double> times;
  for (const double given : options.times) {
    const auto time = model::timeWithin(source, given);
    if (!time) {
      return invalid(fmt::format("time {} is outside the mesh, which lasts from {} to {}", given,
                                 span.begin, span.end));
    }
    times.push_back(*time);
  }
  if (options.layers) {
    for (std::size_t i = 0; i < source.slabCount(); ++i) times.push_back(source.timeSpan(i).begin);
    times.push_back(span.end);
  }
  Tracker tracker(span, std::move(times), options.surfaces);
  if (auto read = model::pump(source, tracker, progress); !read) return read.error();
  Tracks tracks = tracker.finish();
  if (options.minVolume > 0 || options.minDuration > 0) {
    prune(tracks, options.minVolume, options.minDuration);
  }
  return tracks;
}

}  // namespace t4d::measure
