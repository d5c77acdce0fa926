#include "measure/track_parts.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "measure/derived_track.h"
#include "model/source_part.h"
#include "t4d/mesh.h"

namespace t4d::measure {
namespace {

using model::kNoIndex;

/// The slab with which the part that should begin with slab `index` begins: the one before it has a
/// duration.
std::size_t beginOfPart(const model::Source& source, std::size_t index) {
  const auto isFlat = [&](std::size_t i) {
    return source.timeSpan(i).begin == source.timeSpan(i).end;
  };
  while (index > 0 && isFlat(index - 1)) --index;
  return index;
}

/// Appends parts to the tracks of those before.
class JoinedTracks {
 public:
  Result<void> add(PartOfTracks part) {
    if (part.first.size() != open_.size()) {
      return invalid(fmt::format("a part begins with {} surfaces where the one before ends with {}",
                                 part.first.size(), open_.size()));
    }
    std::vector<std::uint32_t> number(part.tracks.tracks.size(), kNoIndex);
    std::vector<std::uint32_t> continued(all_.tracks.size(), kNoIndex);
    std::uint32_t known = 0;
    for (std::size_t i = 0; i < open_.size(); ++i) {
      const std::uint32_t before = open_[i].track;
      const std::uint32_t after = part.first[i].track;
      if (number[after] == kNoIndex && continued[before] == kNoIndex) {
        number[after] = before;
        continued[before] = after;
        ++known;
      } else if (number[after] != before) {
        return invalid(
            "the mesh intersects itself where two parts meet, so that it is not certain "
            "which surfaces there bound one solid");
      }
    }
    for (std::uint32_t i = 0; i < number.size(); ++i) {
      if (number[i] == kNoIndex) {
        number[i] = static_cast<std::uint32_t>(all_.tracks.size()) + i - known;
      }
    }
    addTracks(part.tracks, number, continued);
    addEvents(part, number);
    return {};
  }

  Tracks finish(const TrackOptions& options) {
    setSpeeds(all_);
    if (options.minVolume > 0 || options.minDuration > 0) {
      prune(all_, options.minVolume, options.minDuration);
    }
    return std::move(all_);
  }

 private:
  static void renumber(std::vector<std::uint32_t>& tracks,
                       const std::vector<std::uint32_t>& number) {
    for (std::uint32_t& track : tracks) track = number[track];
  }

  void addTracks(Tracks& more, const std::vector<std::uint32_t>& number,
                 const std::vector<std::uint32_t>& continued) {
    all_.time = more.time;
    const auto known = static_cast<std::uint32_t>(continued.size());
    for (std::uint32_t i = 0; i < more.tracks.size(); ++i) {
      Track& track = more.tracks[i];
      renumber(track.from, number);
      renumber(track.into, number);
      if (number[i] >= known) {
        all_.tracks.push_back(std::move(track));
        continue;
      }
      Track& kept = all_.tracks[number[i]];
      kept.end = std::max(kept.end, track.end);
      kept.endsWithMesh = track.endsWithMesh;
      kept.endsAfter = track.endsAfter;
      kept.into = std::move(track.into);
      kept.largestVolume = std::max(kept.largestVolume, track.largestVolume);
      kept.samples.insert(kept.samples.end(), track.samples.begin(), track.samples.end());
    }
  }

  void addEvents(PartOfTracks& part, const std::vector<std::uint32_t>& number) {
    const std::size_t before = all_.events.size();
    for (TrackEvent& event : part.tracks.events) {
      renumber(event.before, number);
      renumber(event.after, number);
      all_.events.push_back(std::move(event));
    }
    for (const BriefCavity& cavity : part.tracks.briefCavities) {
      all_.briefCavities.push_back(
          {before + cavity.appears, before + cavity.vanishes, cavity.largestVolume});
    }
    for (const CarriedCavity& cavity : part.carriedCavities) {
      const SurfaceAtSeam& was = open_[cavity.atFirst];
      if (!was.appears) continue;
      all_.briefCavities.push_back({*was.appears, before + cavity.vanishes,
                                    std::max(was.largestVolume, cavity.largestVolume)});
    }
    std::ranges::sort(all_.briefCavities, {}, &BriefCavity::vanishes);
    for (SurfaceAtSeam& surface : part.last) {
      surface.track = number[surface.track];
      if (surface.appears) *surface.appears += before;
      if (!surface.atFirst) continue;
      const SurfaceAtSeam& was = open_[*surface.atFirst];
      surface.appears = was.appears;
      surface.largestVolume = std::max(surface.largestVolume, was.largestVolume);
    }
    open_ = std::move(part.last);
  }

  Tracks all_;
  std::vector<SurfaceAtSeam> open_;  // those at the end of the parts so far
};

}  // namespace

Result<PartOfTracks> tracksOfPart(const model::Source& source, const TrackOptions& options,
                                  model::PartRange slabs, const model::Progress& progress) {
  auto times = sampleTimesOf(source, options);
  if (!times) return times.error();
  const model::TimeSpan span = model::timeSpanOf(source);
  if (slabs.begin == source.slabCount()) {
    PartOfTracks nothing;
    nothing.tracks.time = span;
    return nothing;
  }
  const bool atEnd = slabs.end == source.slabCount();
  slabs.begin = beginOfPart(source, slabs.begin);
  if (!atEnd) slabs.end = beginOfPart(source, slabs.end);
  Tracker tracker(span, std::move(*times), options.surfaces);
  if (slabs.begin > 0) {
    const auto before = source.slab(slabs.begin - 1);
    if (!before) return before.error();
    if (auto started = tracker.startAfter(**before); !started) return started.error();
  }
  const model::SourcePart share(source, slabs.begin, slabs.end);
  if (auto read = model::pump(share, tracker, progress); !read) return read.error();
  return tracker.finishPart(atEnd);
}

Result<Tracks> joinedTracks(std::vector<PartOfTracks> parts, const TrackOptions& options) {
  JoinedTracks joined;
  for (PartOfTracks& part : parts) {
    if (auto added = joined.add(std::move(part)); !added) return added.error();
  }
  return joined.finish(options);
}

}  // namespace t4d::measure
