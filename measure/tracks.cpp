#include "measure/tracks.h"

#include <algorithm>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "measure/component_history.h"
#include "measure/derived_track.h"
#include "measure/level_flood.h"
#include "measure/level_surfaces.h"
#include "measure/slab_reeb.h"
#include "model/union_find.h"
#include "t4d/mesh.h"
#include "measure/layer_seam.h"
#include "measure/slab_shells.h"
#include "measure/slab_topology.h"
#include "measure/track_samples.h"

namespace t4d::measure {
namespace {

using model::kNoIndex;

std::vector<double> inOrder(std::vector<double> times) {
  std::ranges::sort(times);
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

}  // namespace

class Tracker::Impl {
 public:
  Impl(model::TimeSpan time, std::vector<double> sampleTimes, bool surfaces)
      : topologies_(inOrder(std::move(sampleTimes)), time.end), history_(time, surfaces) {}

  std::unique_ptr<Prepared> prepare(const model::Slab& slab) const {
    return topologies_.measured(slab);
  }
  Result<void> put(const model::Slab& slab, const MeasuredSlab& measured);
  Tracks finish() {
    history_.work(nullptr, seam_.time(), seam_.take());
    setSpeeds(history_.tracks());
    return std::move(history_.tracks());
  }

 private:
  SlabTopologies topologies_;
  LayerSeam seam_;
  ComponentHistory history_;
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
  SlabShells current(slab, measured);
  auto sample = measured.samples.begin();
  const auto addSamples = [&](double before) {
    for (; sample != measured.samples.end() && sample->time < before; ++sample) {
      addSample(current, *sample, history_);
    }
  };
  history_.work(&current, slab.timeBegin, std::move(transitions));

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
  std::vector<Transition> atLast;
  std::span<const std::uint32_t> lastNodes;
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
    if (last) {
      atLast = std::move(together);
      lastNodes = std::span(order).subspan(begin, i - begin);
    } else {
      history_.work(&current, measured.instants[instant], std::move(together));
    }
  }
  addSamples(std::numeric_limits<double>::infinity());
  seam_.keep(slab, reeb, std::move(atLast), lastNodes);
  addUnsampled(current, topologies_.isSampled(slab.timeEnd), history_);
  return {};
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
