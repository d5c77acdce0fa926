#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "measure/slab_shells.h"
#include "measure/tracks.h"
#include "measure/transition.h"

namespace t4d::measure {

/// The surfaces and solids that exist, and the tracks and events so far.
class ComponentHistory {
 public:
  ComponentHistory(model::TimeSpan time, bool surfaces) : surfaces_(surfaces) {
    tracks_.time = time;
  }

  /// Everything that happens at one time. `current`: the slab after it, or nullptr after the last.
  void work(SlabShells* current, double time, std::vector<Transition> transitions);

  Tracks& tracks() { return tracks_; }
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
};

}  // namespace t4d::measure
