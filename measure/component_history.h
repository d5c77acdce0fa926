#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "measure/slab_shells.h"
#include "measure/track_parts.h"
#include "measure/transition.h"
#include "t4d/check.h"

namespace t4d::measure {

/// The surfaces and solids that exist, and the tracks and events so far.
class ComponentHistory {
 public:
  ComponentHistory(model::TimeSpan time, bool surfaces) : surfaces_(surfaces) {
    tracks_.time = time;
  }

  /// Begins with surfaces that exist at a time, of which `owners` tells whose solids they bound, as
  /// SlabShells::shellsAtEnd does.
  void begin(double time, std::vector<Shell> shells, const std::vector<std::uint32_t>& owners);

  /// Everything that happens at one time. `current`: the slab after it, or nullptr after the last.
  void work(SlabShells* current, double time, std::vector<Transition> transitions);

  /// Notes the surfaces of a track, by its number, from its begin on.
  void follow(std::uint32_t track) { followed_ = track; }
  /// The surfaces that were of the track at some time since the last call of forgetFollowed.
  const std::vector<std::uint32_t>& followedShells() const { return followedShells_; }
  void forgetFollowed() { followedShells_.clear(); }

  /// Forgets the volumes that surfaces had in a slab before.
  void forgetVolumes(const std::vector<Transition>& transitions);

  Tracks& tracks() { return tracks_; }
  /// Cavities of before the first slab that have vanished.
  std::vector<CarriedCavity>& carriedCavities() { return carriedCavities_; }
  std::vector<Shell>& shells() { return shells_; }
  bool ofSurfaces() const { return surfaces_; }
  std::uint32_t trackOf(std::uint32_t shell) const { return solids_[shells_[shell].solid].track; }
  bool hasEnded(std::uint32_t track) const { return ended_[track] != 0; }

 private:
  struct Solid {
    std::uint32_t track = 0;
    std::vector<std::uint32_t> shells = {};
  };

  void workSurfaces(double time, std::vector<Transition*>& transitions);
  void workSolids(SlabShells* current, double time, std::vector<Transition*>& transitions);
  void addDetails(double time, const std::vector<Transition*>& transitions);
  std::uint32_t addTrack(double time, bool cavity);
  void endTrack(std::uint32_t track, double time);
  bool atStart(double time) const { return time == tracks_.time.begin; }
  bool atEnd(double time) const { return time == tracks_.time.end; }
  void addEvent(double time, TrackEventKind kind, const model::Point3& place,
                std::vector<std::uint32_t> before, std::vector<std::uint32_t> after,
                std::uint64_t count, std::int64_t euler) {
    tracks_.events.push_back(
        {time, kind, place, std::move(before), std::move(after), count, euler});
  }

  bool surfaces_;
  Tracks tracks_;
  std::vector<char> ended_;  // for each track
  std::vector<Shell> shells_;
  std::vector<Solid> solids_;
  std::vector<CarriedCavity> carriedCavities_;
  std::uint32_t followed_ = model::kNoIndex;
  std::uint32_t followedSolid_ = model::kNoIndex;
  std::vector<std::uint32_t> followedShells_;
};

}  // namespace t4d::measure
