#include "measure/track_samples.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <span>

#include "measure/level_surfaces.h"

namespace t4d::measure {

using model::kNoIndex;

void addSample(const SlabShells& current, const ArcMeasures& sample, ComponentHistory& history) {
  std::vector<Shell>& shells = history.shells();
  std::vector<Track>& tracks = history.tracks().tracks;
  std::map<std::uint32_t, SolidMeasures> ofTracks;
  for (const auto& [arc, measures] : sample.ofArcs) {
    const std::uint32_t shell = current.shellOfArc[arc];
    if (shell == kNoIndex) continue;
    shells[shell].volume = std::abs(measures.volume);
    shells[shell].largestVolume = std::max(shells[shell].largestVolume, shells[shell].volume);
    SolidMeasures one = measures;
    one.components = shells[shell].outer ? 1 : 0;
    one.cavities = 1 - one.components;
    one.genus = 1 - static_cast<double>(shells[shell].euler2) / 4;
    SolidMeasures& sum = ofTracks[history.trackOf(shell)];
    sum.add(one);
    sum.time = sample.time;
  }
  for (const auto& [number, measures] : ofTracks) {
    Track& track = tracks[number];
    track.largestVolume = std::max(track.largestVolume, std::abs(measures.volume));
    track.samples.push_back({measures});
  }
}

void addUnsampled(SlabShells& current, bool atNext, ComponentHistory& history) {
  const std::vector<Shell>& shells = history.shells();
  std::vector<Track>& tracks = history.tracks().tracks;
  const SlabReeb& reeb = current.reeb();
  struct Middle {
    double time;
    std::uint32_t vertex = kNoIndex;
  };
  std::map<std::uint32_t, Middle> ofArcs;
  for (std::uint32_t a = 0; a < reeb.arcs.size(); ++a) {
    const std::uint32_t shell = current.shellOfArc[a];
    if (shell == kNoIndex || (!history.ofSurfaces() && !shells[shell].outer)) continue;
    const std::uint32_t number = history.trackOf(shell);
    Track& track = tracks[number];
    if (!track.samples.empty() || track.begin < current.slab().timeBegin) continue;
    if (!history.hasEnded(number) && atNext) continue;
    track.largestVolume = std::max(track.largestVolume, shells[shell].volume);
    if (track.largestVolume > 0) continue;
    const double end = history.hasEnded(number) ? track.end : current.slab().timeEnd;
    ofArcs[a] = {track.begin + (end - track.begin) / 2};
  }
  if (ofArcs.empty()) return;
  for (std::uint32_t v = 0; v < reeb.arcOfVertex.size(); ++v) {
    if (reeb.arcOfVertex[v] == kNoIndex) continue;
    const auto at = ofArcs.find(reeb.arcOfVertex[v]);
    if (at == ofArcs.end()) continue;
    const auto distance = [&](std::uint32_t vertex) {
      return std::abs(current.slab().vertices[vertex][3] - at->second.time);
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
    const std::vector<double>& instants = current.instants();
    const double time = vertex != kNoIndex ? current.slab().vertices[vertex][3]
                                           : (instants[instant] + instants[instant + 1]) / 2;
    const std::uint32_t cell = stretch.cell;
    const auto star = vertex != kNoIndex ? current.flooding().stars().of(vertex)
                                         : std::span<const std::uint32_t>(&cell, 1);
    const auto found = current.flooding().surfaces(time, star, false);
    Track& track = tracks[history.trackOf(current.shellOfArc[stretch.arc])];
    if (!found.empty()) {
      const double volume = localSurface(current.slab(), found.front().cells, time).measures.volume;
      track.largestVolume = std::max(track.largestVolume, std::abs(volume));
    }
    ofArcs.erase(at);
  }
}

}  // namespace t4d::measure
