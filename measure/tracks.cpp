#include <algorithm>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "measure/component_history.h"
#include "measure/derived_track.h"
#include "measure/layer_seam.h"
#include "measure/level_flood.h"
#include "measure/level_surfaces.h"
#include "measure/slab_reeb.h"
#include "measure/slab_shells.h"
#include "measure/slab_topology.h"
#include "measure/track_parts.h"
#include "measure/track_samples.h"
#include "model/union_find.h"
#include "t4d/check.h"
#include "t4d/mesh.h"

namespace t4d::measure {

using model::kNoIndex;

class Tracker::Impl {
 public:
  Impl(model::TimeSpan time, std::vector<double> sampleTimes, bool surfaces)
      : topologies_(std::move(sampleTimes), time.end), history_(time, surfaces) {}

  std::unique_ptr<Prepared> prepare(const model::Slab& slab) const {
    return topologies_.measured(slab);
  }
  Result<void> put(const model::Slab& slab, const MeasuredSlab& measured);
  Result<void> startAfter(const model::Slab& slab);
  PartOfTracks finishPart(bool atEnd);
  void follow(std::uint32_t track) {
    follows_ = track;
    history_.follow(track);
  }
  const FollowedTrack& followed() const { return followed_; }

 private:
  void setFollowed();
  void followIn(const SlabShells& current);
  void endSlab(const SlabShells& current, std::span<const std::uint32_t> nodes);
  std::vector<SurfaceAtSeam> surfacesAt(const std::vector<std::uint32_t>& shells);

  SlabTopologies topologies_;
  LayerSeam seam_;
  ComponentHistory history_;
  std::vector<std::uint32_t> atEnd_;  // shells of the arcs at the end of the last slab
  std::vector<SurfaceAtSeam> first_;
  double firstTime_ = 0;
  std::uint32_t follows_ = kNoIndex;
  FollowedTrack followed_;
};

Result<void> Tracker::Impl::put(const model::Slab& slab, const MeasuredSlab& measured) {
  if (!measured.sound) return measured.sound.error();
  if (slab.timeBegin > seam_.time() && !seam_.isEmpty()) {
    // A gap in time, before which everything has ended.
    history_.work(nullptr, seam_.time(), seam_.take());
  }
  const SlabReeb& reeb = measured.topology->reeb;
  std::vector<Transition> transitions = seam_.join(slab, reeb);
  if (slab.timeBegin == slab.timeEnd) return {};
  history_.forgetVolumes(transitions);
  history_.forgetFollowed();
  SlabShells current(slab, measured);
  auto sample = measured.samples.begin();
  const auto addSamples = [&](double before) {
    for (; sample != measured.samples.end() && sample->time < before; ++sample) {
      addSample(current, *sample, history_);
    }
  };
  history_.work(&current, slab.timeBegin, std::move(transitions));

  const std::vector<std::uint32_t> order = current.nodesInOrder();
  std::span<const std::uint32_t> nodes = order;
  while (!nodes.empty() && reeb.nodes[nodes.front()].instant < reeb.lastInstant) {
    const std::uint32_t instant = reeb.nodes[nodes.front()].instant;
    std::size_t count = 1;
    while (count < nodes.size() && reeb.nodes[nodes[count]].instant == instant) ++count;
    addSamples(measured.instants[instant]);
    history_.work(&current, measured.instants[instant], current.transitionsAt(nodes.first(count)));
    nodes = nodes.subspan(count);
  }
  addSamples(std::numeric_limits<double>::infinity());
  endSlab(current, nodes);
  addUnsampled(current, topologies_.isSampled(slab.timeEnd), history_);
  followIn(current);
  return {};
}

void Tracker::Impl::setFollowed() {
  if (follows_ >= history_.tracks().tracks.size()) return;
  const Track& track = history_.tracks().tracks[follows_];
  followed_.begun = true;
  followed_.begin = track.begin;
  followed_.ended = history_.hasEnded(follows_);
  followed_.end = track.end;
}

void Tracker::Impl::followIn(const SlabShells& current) {
  setFollowed();
  followed_.cells.clear();
  if (history_.followedShells().empty()) return;
  std::vector<std::uint32_t> shells = history_.followedShells();
  std::ranges::sort(shells);
  const std::vector<double>& instants = current.instants();
  for (const SlabReeb::Stretch& stretch : current.reeb().stretches) {
    if (!std::ranges::binary_search(shells, current.shellOfArc[stretch.arc])) continue;
    // Slots of open intervals are odd: an arc may be of another track before or after.
    const bool reaches = instants[(stretch.lastSlot + 1) / 2] > followed_.begin &&
                         (!followed_.ended || instants[stretch.firstSlot / 2] < followed_.end);
    if (reaches) followed_.cells.push_back(stretch.cell);
  }
}

void Tracker::Impl::endSlab(const SlabShells& current, std::span<const std::uint32_t> nodes) {
  seam_.keep(current.slab(), current.reeb(), current.transitionsAt(nodes), nodes);
  atEnd_.clear();
  for (const std::uint32_t arc : current.arcsAtEnd()) atEnd_.push_back(current.shellOfArc[arc]);
}

Result<void> Tracker::Impl::startAfter(const model::Slab& slab) {
  const auto measured = topologies_.measured(slab, /*sampled=*/false);
  if (!measured->sound) return measured->sound;
  SlabShells current(slab, *measured);
  std::vector<std::uint32_t> owners;
  history_.begin(slab.timeBegin, current.shellsAtEnd(owners), owners);
  const std::vector<std::uint32_t> arcs = current.arcsAtEnd();
  for (std::uint32_t i = 0; i < arcs.size(); ++i) current.shellOfArc[arcs[i]] = i;
  std::vector<std::uint32_t> nodes = current.nodesInOrder();
  std::erase_if(nodes, [&](std::uint32_t n) {
    return current.reeb().nodes[n].instant < current.reeb().lastInstant;
  });
  endSlab(current, nodes);
  first_ = surfacesAt(atEnd_);
  firstTime_ = slab.timeEnd;
  return {};
}

std::vector<SurfaceAtSeam> Tracker::Impl::surfacesAt(const std::vector<std::uint32_t>& shells) {
  std::vector<SurfaceAtSeam> surfaces;
  for (const std::uint32_t number : shells) {
    SurfaceAtSeam& surface = surfaces.emplace_back();
    if (number == kNoIndex) continue;
    const Shell& shell = history_.shells()[number];
    surface.track = history_.trackOf(number);
    if (shell.appears != kNoEvent) surface.appears = shell.appears;
    if (shell.atFirst != kNoIndex) surface.atFirst = shell.atFirst;
    surface.largestVolume = shell.largestVolume;
  }
  return surfaces;
}

PartOfTracks Tracker::Impl::finishPart(bool atEnd) {
  PartOfTracks part;
  if (atEnd) {
    history_.work(nullptr, seam_.time(), seam_.take());
    setFollowed();
  } else {
    part.last = surfacesAt(atEnd_);
  }
  part.first = std::move(first_);
  part.carriedCavities = std::move(history_.carriedCavities());
  part.tracks = std::move(history_.tracks());
  for (const SurfaceAtSeam& surface : part.first) {
    Track& track = part.tracks.tracks[surface.track];
    track.beginsBefore = true;
    track.begin = firstTime_;
  }
  for (const SurfaceAtSeam& surface : part.last) {
    Track& track = part.tracks.tracks[surface.track];
    track.endsAfter = true;
    track.end = seam_.time();
  }
  return part;
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
  return impl_->put(slab, static_cast<const MeasuredSlab&>(*prepared));
}
void Tracker::follow(std::uint32_t track) { impl_->follow(track); }
const FollowedTrack& Tracker::followed() const { return impl_->followed(); }
Result<void> Tracker::startAfter(const model::Slab& slab) { return impl_->startAfter(slab); }
PartOfTracks Tracker::finishPart(bool atEnd) { return impl_->finishPart(atEnd); }
Tracks Tracker::finish() {
  Tracks tracks = impl_->finishPart(true).tracks;
  setSpeeds(tracks);
  return tracks;
}

Result<std::vector<double>> sampleTimesOf(const model::Source& source,
                                          const TrackOptions& options) {
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
  std::ranges::sort(times);
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

Result<Tracks> tracksOf(const model::Source& source, const TrackOptions& options,
                        const model::Progress& progress) {
  auto times = sampleTimesOf(source, options);
  if (!times) return times.error();
  Tracker tracker(model::timeSpanOf(source), std::move(*times), options.surfaces);
  if (auto read = model::pump(source, tracker, progress); !read) return read.error();
  Tracks tracks = tracker.finish();
  if (options.minVolume > 0 || options.minDuration > 0) {
    prune(tracks, options.minVolume, options.minDuration);
  }
  return tracks;
}

}  // namespace t4d::measure
