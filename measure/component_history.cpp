#include "measure/component_history.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <unordered_map>

#include "measure/derived_track.h"
#include "model/union_find.h"

namespace t4d::measure {

using model::kNoIndex;
using model::Point3;

void ComponentHistory::begin(double time, std::vector<Shell> shells,
                             const std::vector<std::uint32_t>& owners) {
  shells_ = std::move(shells);
  const auto addSolid = [&](std::uint32_t shell) {
    shells_[shell].solid = static_cast<std::uint32_t>(solids_.size());
    solids_.push_back({addTrack(time, !shells_[shell].outer), {shell}});
  };
  for (std::uint32_t i = 0; i < shells_.size(); ++i) {
    if (surfaces_ || shells_[i].outer || owners[i] == kNoIndex) addSolid(i);
  }
  for (std::uint32_t i = 0; i < shells_.size(); ++i) {
    if (shells_[i].solid != kNoIndex) continue;
    shells_[i].solid = shells_[owners[i]].solid;
    solids_[shells_[i].solid].shells.push_back(i);
  }
}

void ComponentHistory::forgetVolumes(const std::vector<Transition>& transitions) {
  for (const Transition& one : transitions) {
    for (const std::uint32_t shell : one.shellsBelow) {
      shells_[shell].volume = std::numeric_limits<double>::quiet_NaN();
    }
  }
}

std::uint32_t ComponentHistory::addTrack(double time, bool cavity) {
  Track track;
  track.begin = track.end = time;
  track.beginsWithMesh = atStart(time);
  track.cavity = cavity;
  const auto number = static_cast<std::uint32_t>(tracks_.tracks.size());
  tracks_.tracks.push_back(std::move(track));
  ended_.push_back(0);
  // Each track has a solid, which is added next.
  if (number == followed_) followedSolid_ = static_cast<std::uint32_t>(solids_.size());
  return number;
}

void ComponentHistory::endTrack(std::uint32_t track, double time) {
  ended_[track] = 1;
  tracks_.tracks[track].end = time;
  tracks_.tracks[track].endsWithMesh = atEnd(time);
}

/// Everything that happens at one time.
void ComponentHistory::work(SlabShells* current, double time, std::vector<Transition> transitions) {
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
    if (!one->arcsAbove.empty()) current->make(*one, !surfaces_, shells_);
  }
  if (surfaces_) {
    workSurfaces(time, real);
  } else {
    workSolids(current, time, real);
  }
  if (!atStart(time) && !atEnd(time)) addDetails(time, real);
  if (followedSolid_ != kNoIndex && !hasEnded(followed_)) {
    const std::vector<std::uint32_t>& shells = solids_[followedSolid_].shells;
    followedShells_.insert(followedShells_.end(), shells.begin(), shells.end());
  }
}

/// Every surface is a track of its own.
void ComponentHistory::workSurfaces(double time, std::vector<Transition*>& transitions) {
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
void ComponentHistory::workSolids(SlabShells* current, double time,
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

  // Where a class has one outward surface, all its cavities are in that; owners of others are
  // searched.
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
    const auto next = current->nextShells(time, unknown);
    std::unordered_map<std::uint32_t, std::uint32_t> nextOf;
    for (std::size_t i = 0; i < unknown.size(); ++i) nextOf[unknown[i]] = next[i];
    for (const std::uint32_t shell : unknown) {
      std::uint32_t at = shell;
      // Steps from cavity to cavity of one solid; each is farther along the ray's direction.
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
void ComponentHistory::addDetails(double time, const std::vector<Transition*>& transitions) {
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
      // The tracks of a cavity alone are those of its solid, which goes on.
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
        const std::size_t vanishes = tracks_.events.size() - 1;
        if (shell.appears != kNoEvent) {
          tracks_.briefCavities.push_back({shell.appears, vanishes, shell.largestVolume});
        } else if (shell.atFirst != kNoIndex) {
          carriedCavities_.push_back({shell.atFirst, vanishes, shell.largestVolume});
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

}  // namespace t4d::measure
