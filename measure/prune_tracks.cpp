#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "measure/derived_track.h"
#include "measure/transition.h"
#include "t4d/check.h"
#include "t4d/mesh.h"

namespace t4d::measure {
namespace {

using model::kNoIndex;

bool isOfTracks(const TrackEvent& event) { return event.kind <= TrackEventKind::Rearranges; }

/// Tracks and the events between them while some are left out.
class Pruning {
 public:
  Pruning(Tracks& tracks, double minVolume, double minDuration)
      : tracks_(tracks),
        minVolume_(minVolume),
        minDuration_(minDuration),
        begin_(tracks.tracks.size(), kNoEvent),
        end_(tracks.tracks.size(), kNoEvent),
        now_(tracks.tracks.size()),
        gone_(tracks.events.size(), 0) {
    std::iota(now_.begin(), now_.end(), 0U);
    for (std::size_t e = 0; e < tracks.events.size(); ++e) {
      if (!isOfTracks(tracks.events[e])) continue;
      for (const std::uint32_t track : tracks.events[e].before) end_[track] = e;
      for (const std::uint32_t track : tracks.events[e].after) begin_[track] = e;
    }
  }

  void run() {
    std::multimap<double, std::uint32_t> small;  // by duration
    const auto add = [&](std::uint32_t number) {
      const Track& track = tracks_.tracks[number];
      const double duration = track.end - track.begin;
      if (duration < minDuration_ || track.largestVolume < minVolume_) {
        small.emplace(duration, number);
      }
    };
    for (std::uint32_t i = 0; i < now_.size(); ++i) add(i);
    while (!small.empty()) {
      const auto [duration, number] = *small.begin();
      small.erase(small.begin());
      const Track& track = tracks_.tracks[number];
      if (now_[number] != number || duration != track.end - track.begin) continue;
      if (!isFree(begin_[number], &TrackEvent::before, &TrackEvent::after) ||
          !isFree(end_[number], &TrackEvent::after, &TrackEvent::before)) {
        continue;
      }
      now_[number] = kNoIndex;
      ++tracks_.prunedTracks;
      const std::array<std::size_t, 2> events = {begin_[number], end_[number]};
      for (const std::size_t event : events) {
        if (event == kNoEvent) continue;
        std::erase(tracks_.events[event].before, number);
        std::erase(tracks_.events[event].after, number);
      }
      for (const std::size_t event : events) {
        if (const auto joined = settle(event)) add(*joined);
      }
    }
    for (const BriefCavity& cavity : tracks_.briefCavities) {
      const double duration =
          tracks_.events[cavity.vanishes].time - tracks_.events[cavity.appears].time;
      if (duration >= minDuration_ && cavity.largestVolume >= minVolume_) continue;
      gone_[cavity.appears] = gone_[cavity.vanishes] = 1;
    }
    finish();
  }

 private:
  using Side = std::vector<std::uint32_t> TrackEvent::*;

  /// Whether a track can be left out of one of its two events.
  bool isFree(std::size_t event, Side far, Side own) const {
    if (event == kNoEvent) return true;
    const TrackEvent& at = tracks_.events[event];
    return (at.*far).empty() || (at.*own).size() > 1;
  }

  /// After a track has left an event: removes the event if nothing happens there any more. If two
  /// tracks become one, returns it.
  std::optional<std::uint32_t> settle(std::size_t number) {
    if (number == kNoEvent || gone_[number] != 0) return {};
    const TrackEvent& event = tracks_.events[number];
    if (event.before.empty() && event.after.empty()) gone_[number] = 1;
    if (event.before.size() != 1 || event.after.size() != 1) return {};
    gone_[number] = 1;
    const std::uint32_t kept = event.before[0];
    const std::uint32_t other = event.after[0];
    Track& track = tracks_.tracks[kept];
    Track& more = tracks_.tracks[other];
    track.end = more.end;
    track.endsWithMesh = more.endsWithMesh;
    track.largestVolume = std::max(track.largestVolume, more.largestVolume);
    track.samples.insert(track.samples.end(), more.samples.begin(), more.samples.end());
    more.samples.clear();
    now_[other] = kept;
    end_[kept] = end_[other];
    if (end_[kept] != kNoEvent) {
      std::ranges::replace(tracks_.events[end_[kept]].before, other, kept);
    }
    return kept;
  }

  std::uint32_t nowOf(std::uint32_t track) const {
    while (track != kNoIndex && now_[track] != track) track = now_[track];
    return track;
  }

  void finish() {
    std::vector<std::uint32_t> number(now_.size(), kNoIndex);
    std::vector<Track> tracks;
    for (std::uint32_t i = 0; i < now_.size(); ++i) {
      if (now_[i] != i) continue;
      number[i] = static_cast<std::uint32_t>(tracks.size());
      tracks.push_back(std::move(tracks_.tracks[i]));
      tracks.back().from.clear();
      tracks.back().into.clear();
    }
    std::vector<TrackEvent> events;
    for (std::size_t e = 0; e < tracks_.events.size(); ++e) {
      TrackEvent event = std::move(tracks_.events[e]);
      const auto renumber = [&](std::vector<std::uint32_t>& side) {
        std::vector<std::uint32_t> now;
        for (const std::uint32_t track : side) {
          const std::uint32_t kept = nowOf(track);
          if (kept == kNoIndex) continue;
          if (std::ranges::find(now, number[kept]) == now.end()) now.push_back(number[kept]);
        }
        side = std::move(now);
      };
      renumber(event.before);
      renumber(event.after);
      if (gone_[e] != 0 || (event.before.empty() && event.after.empty())) {
        ++tracks_.prunedEvents;
        continue;
      }
      if (isOfTracks(event)) {
        event.kind = trackKindOf(event.before.size(), event.after.size());
        event.count = trackCountOf(event.before.size(), event.after.size());
        for (const std::uint32_t track : event.before) tracks[track].into = event.after;
        for (const std::uint32_t track : event.after) tracks[track].from = event.before;
      }
      events.push_back(std::move(event));
    }
    tracks_.tracks = std::move(tracks);
    tracks_.events = std::move(events);
    tracks_.briefCavities.clear();
    setSpeeds(tracks_);
  }

  Tracks& tracks_;
  double minVolume_;
  double minDuration_;
  std::vector<std::size_t> begin_;  // event of each track
  std::vector<std::size_t> end_;
  std::vector<std::uint32_t> now_;  // the track that it is part of, or model::kNoIndex
  std::vector<char> gone_;          // for each event
};

}  // namespace

void prune(Tracks& tracks, double minVolume, double minDuration) {
  Pruning(tracks, minVolume, minDuration).run();
}

}  // namespace t4d::measure
