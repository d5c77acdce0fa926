#include "t4d/collide.h"

#include <algorithm>
#include <array>
#include <deque>
#include <map>
#include <tuple>
#include <utility>

#include "measure/pair_search.h"
#include "model/parallel.h"
#include "model/progress.h"
#include "model/unit_scale.h"

namespace t4d::measure {
namespace {

using model::Source;
using model::TimeSpan;

/// The searches of several pairs side by side in time, so that what is known of a slab serves all
/// pairs of its body.
class PairSearches {
 public:
  PairSearches(std::span<const SourcePair> pairs, const CollideOptions& options)
      : overTime_(options.clearanceOverTime) {
    std::map<const Source*, std::size_t> numbers;
    const auto numberOf = [&](const Source& source) {
      const auto [found, added] = numbers.try_emplace(&source, slabs_.size());
      if (added) slabs_.emplace_back(source);
      return found->second;
    };
    for (const auto& [a, b] : pairs) {
      bodies_.push_back({numberOf(*a), numberOf(*b)});
      searches_.emplace_back(slabs_[bodies_.back()[0]], slabs_[bodies_.back()[1]], options);
    }
  }

  Result<std::vector<Collision>> run(const model::Progress& progress) {
    constexpr double kContacts = 0.5;  // of the work
    const auto all = [](std::size_t /*pair*/) { return true; };
    const auto always = [](const Visit& /*visit*/) { return true; };
    auto done = forEachWindow(
        all, always,
        [&](const Visit& visit) { return searches_[visit.pair].findContacts(visit.window); },
        model::partOf(progress, 0, kContacts));
    if (!done) return done.error();
    for (PairSearch& search : searches_) search.finishContacts();
    const auto apart = [&](std::size_t pair) { return searches_[pair].findsClearance(); };
    const auto isSeeded = [&](std::size_t pair) { return apart(pair) && !overTime_; };
    // A distance that is small from the start leaves out most of the others.
    const auto isFirst = [&](const Visit& visit) {
      return visit.window == searches_[visit.pair].nearestByBoxes();
    };
    done = forEachWindow(isSeeded, isFirst,
                         [&](const Visit& visit) -> Result<void> {
                           if (isFirst(visit)) searches_[visit.pair].findClearance(visit.window);
                           return {};
                         },
                         {});
    if (!done) return done.error();
    done = forEachWindow(
        apart, [&](const Visit& visit) { return searches_[visit.pair].mayBeNearest(visit.window); },
        [&](const Visit& visit) -> Result<void> {
          searches_[visit.pair].findClearance(visit.window);
          return {};
        },
        model::partOf(progress, kContacts, 1));
    if (!done) return done.error();
    std::vector<Collision> collisions;
    for (PairSearch& search : searches_) {
      auto collision = search.finish();
      if (!collision) return collision.error();
      collisions.push_back(std::move(*collision));
    }
    return collisions;
  }

 private:
  /// A window of a pair.
  struct Visit {
    TimeSpan span;
    std::size_t pair = 0;
    std::size_t window = 0;
  };

  const SlabWindow& windowOf(const Visit& visit) const {
    return searches_[visit.pair].windows()[visit.window];
  }

  /// Visits the windows of some pairs in time order, those that are at the same time together, with
  /// their slabs loaded if they are needed.
  template <class Has, class Needs, class Do>
  Result<void> forEachWindow(const Has& has, const Needs& needs, const Do& visitOne,
                             const model::Progress& progress) {
    std::vector<Visit> visits;
    for (std::size_t pair = 0; pair < searches_.size(); ++pair) {
      const auto& windows = searches_[pair].windows();
      for (std::size_t i = 0; has(pair) && i < windows.size(); ++i) {
        visits.push_back({windows[i].span, pair, i});
      }
    }
    std::ranges::stable_sort(
        visits, {}, [](const Visit& visit) { return std::pair(visit.span.begin, visit.span.end); });
    for (std::size_t begin = 0, end = 0; begin < visits.size(); begin = end) {
      std::map<std::size_t, std::size_t> needed;
      for (; end < visits.size() && isTogether(visits, begin, end, needed); ++end) {
        if (!needs(visits[end])) continue;
        needed.emplace(bodies_[visits[end].pair][0], windowOf(visits[end]).slabA);
        needed.emplace(bodies_[visits[end].pair][1], windowOf(visits[end]).slabB);
      }
      if (auto loaded = load(needed, visits[begin].span); !loaded) return loaded;
      std::vector<Result<void>> done(end - begin);
      model::forEach(done.size(), [&](std::size_t i) { done[i] = visitOne(visits[begin + i]); });
      for (const Result<void>& one : done) {
        if (!one) return one;
      }
      if (auto on = model::report(progress, end, visits.size()); !on) return on;
    }
    return {};
  }

  /// Whether a visit is at the same time as the first, needs no other slabs of the same bodies, and
  /// is of another pair than the one before.
  bool isTogether(std::span<const Visit> visits, std::size_t first, std::size_t one,
                  const std::map<std::size_t, std::size_t>& needed) const {
    if (one == first) return true;
    const auto& [span, pair, window] = visits[one];
    if (span.begin != visits[first].span.begin || span.end != visits[first].span.end) return false;
    if (pair == visits[one - 1].pair) return false;
    const auto fits = [&](std::size_t body, std::size_t slab) {
      const auto found = needed.find(body);
      return found == needed.end() || found->second == slab;
    };
    return fits(bodies_[pair][0], windowOf(visits[one]).slabA) &&
           fits(bodies_[pair][1], windowOf(visits[one]).slabB);
  }

  Result<void> load(const std::map<std::size_t, std::size_t>& needed, const TimeSpan& span) {
    const std::vector<std::pair<std::size_t, std::size_t>> all(needed.begin(), needed.end());
    std::vector<Result<void>> loaded(all.size());
    model::forEach(all.size(), [&](std::size_t i) {
      loaded[i] = slabs_[all[i].first].load(all[i].second, span);
    });
    for (const Result<void>& one : loaded) {
      if (!one) return one;
    }
    return {};
  }

  bool overTime_;
  std::deque<LoadedSlab> slabs_;                    // of each body
  std::vector<std::array<std::size_t, 2>> bodies_;  // of each pair
  std::deque<PairSearch> searches_;
};

void scaleBack(Collision& collision, const model::UnitScale& space, const model::UnitScale& time) {
  const auto span = [&](TimeSpan& times) {
    times = {time.fromUnit(times.begin), time.fromUnit(times.end)};
  };
  if (collision.common) span(*collision.common);
  for (ContactInterval& interval : collision.intervals) {
    span(interval.crossing);
    for (double* t :
         {&interval.begin, &interval.end, &interval.deepestTime, &interval.first.time}) {
      *t = time.fromUnit(*t);
    }
    interval.first.point = space.fromUnit(interval.first.point);
    interval.overlapVolume = space.fromUnit(interval.overlapVolume, 3);
    interval.volumeError = space.fromUnit(interval.volumeError, 3);
  }
  if (collision.clearance) {
    Clearance& clearance = *collision.clearance;
    clearance.distance = space.fromUnit(clearance.distance);
    clearance.lowerBound = space.fromUnit(clearance.lowerBound);
    clearance.time = time.fromUnit(clearance.time);
    clearance.pointA = space.fromUnit(clearance.pointA);
    clearance.pointB = space.fromUnit(clearance.pointB);
  }
  for (ClearanceOver& over : collision.clearanceOverTime) {
    span(over.span);
    over.distance = space.fromUnit(over.distance);
  }
}

/// A pair whose sizes or times are far from 1, in units of its own.
Result<Collision> collideInUnits(const SourcePair& pair, const model::UnitScale& space,
                                 const model::UnitScale& time, const CollideOptions& options) {
  const model::UnitSource a(*pair.a, space, time);
  const model::UnitSource b(*pair.b, space, time);
  const SourcePair inUnits{&a, &b};
  auto collisions = PairSearches({&inUnits, 1}, options).run({});
  if (!collisions) return collisions.error();
  scaleBack(collisions->front(), space, time);
  return std::move(collisions->front());
}

}  // namespace

Result<std::vector<Collision>> collideAll(std::span<const SourcePair> pairs,
                                          const CollideOptions& options,
                                          const model::Progress& progress) {
  std::vector<Collision> collisions(pairs.size());
  std::vector<SourcePair> together;
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const std::array<const Source*, 2> both = {pairs[i].a, pairs[i].b};
    const auto space = model::spaceScaleOf(both);
    if (!space) return space.error();
    const model::UnitScale time = model::timeScaleOf(both);
    if (!space->changes() && !time.changes()) {
      together.push_back(pairs[i]);
      numbers.push_back(i);
      continue;
    }
    auto alone = collideInUnits(pairs[i], *space, time, options);
    if (!alone) return alone.error();
    collisions[i] = std::move(*alone);
  }
  auto found = PairSearches(together, options).run(progress);
  if (!found) return found.error();
  for (std::size_t i = 0; i < numbers.size(); ++i) collisions[numbers[i]] = std::move((*found)[i]);
  if (auto on = model::report(progress, 1); !on) return on.error();
  return collisions;
}

Result<Collision> collide(const Source& a, const Source& b, const CollideOptions& options,
                          const model::Progress& progress) {
  const SourcePair pair{&a, &b};
  auto collisions = collideAll({&pair, 1}, options, progress);
  if (!collisions) return collisions.error();
  return std::move(collisions->front());
}

}  // namespace t4d::measure
