#pragma once

#include <cstddef>
#include <cstdint>

#include "t4d/check.h"

/// Data of tracks and events that follows from the rest.
namespace t4d::measure {

/// The kind and the count of an event in which so many tracks end and begin.
inline TrackEventKind trackKindOf(std::size_t before, std::size_t after) {
  if (before == 0) return TrackEventKind::Appears;
  if (after == 0) return TrackEventKind::Vanishes;
  if (before == 1) return TrackEventKind::Splits;
  return after == 1 ? TrackEventKind::Merges : TrackEventKind::Rearranges;
}
inline std::uint64_t trackCountOf(std::size_t before, std::size_t after) {
  return before > after ? before - after : after - before;
}

/// The speed of each sample but the first of a track.
inline void setSpeeds(Tracks& tracks) {
  for (Track& track : tracks.tracks) {
    for (std::size_t i = 1; i < track.samples.size(); ++i) {
      const SolidMeasures& before = track.samples[i - 1].measures;
      const SolidMeasures& now = track.samples[i].measures;
      track.samples[i].speed = (now.centroid - before.centroid).norm() / (now.time - before.time);
    }
  }
}

}  // namespace t4d::measure
