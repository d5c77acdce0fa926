#include "measure/slab_topology.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "t4d/mesh.h"

namespace t4d::measure {
namespace {

using model::kNoIndex;

struct Ranks {
  std::vector<std::uint8_t> ofInterior;
  bool exact = true;
};

/// The ranks of the times of interior vertices among them; nothing if there are many. Times that
/// differ by rounding, such as those of means of four and of six vertices, are of one rank.
std::optional<Ranks> ranksOf(const model::Slab& slab) {
  constexpr std::size_t kMost = 16;
  const model::Connectivity& connectivity = *slab.connectivity;
  std::vector<double> times = {slab.timeBegin, slab.timeEnd};
  double last = slab.timeBegin;
  for (std::uint32_t v = connectivity.lowerCount; v < connectivity.firstUpper(); ++v) {
    const double time = slab.vertices[v][3];
    if (time == last) continue;
    last = time;
    if (std::ranges::find(times, time) != times.end()) continue;
    times.push_back(time);
    if (times.size() > kMost) return {};
  }
  std::ranges::sort(times);
  const double rounding = model::kSameTimeUlps * std::numeric_limits<double>::epsilon() *
                          std::max(std::abs(slab.timeBegin), std::abs(slab.timeEnd));
  Ranks ranks;
  std::vector<std::uint8_t> rankOf(times.size(), 0);
  for (std::size_t i = 1; i < times.size(); ++i) {
    const bool apart = times[i] - times[i - 1] > rounding;
    if (!apart && times[i] != times[i - 1]) ranks.exact = false;
    rankOf[i] = static_cast<std::uint8_t>(rankOf[i - 1] + (apart ? 1 : 0));
  }
  ranks.ofInterior.reserve(connectivity.firstUpper() - connectivity.lowerCount);
  for (std::uint32_t v = connectivity.lowerCount; v < connectivity.firstUpper(); ++v) {
    const auto at = std::ranges::lower_bound(times, slab.vertices[v][3]);
    ranks.ofInterior.push_back(rankOf[static_cast<std::size_t>(at - times.begin())]);
  }
  return ranks;
}

ArcMeasures sampleOf(const model::Slab& slab, const MeasuredSlab& measured, double time) {
  const SlabTopology& topology = *measured.topology;
  ArcMeasures sample{time, {}};
  const auto add = [&](const LevelSurfaces& surfaces, const std::vector<std::uint32_t>& arcs) {
    const auto measures = measuresOf(surfaces, pointsAt(surfaces.cut, slab.vertices, time), time);
    for (std::uint32_t s = 0; s < surfaces.count; ++s) {
      if (arcs[s] != kNoIndex) sample.ofArcs.emplace_back(arcs[s], measures[s]);
    }
  };
  if (time == slab.timeBegin) {
    add(topology.atLower, topology.arcsAtLower);
    return sample;
  }
  const bool end = time == slab.timeEnd;
  const auto surfaces = levelSurfaces(slab.connectivity->cells, verticesAfter(slab, time, end));
  const std::uint32_t slot =
      end ? 2 * topology.reeb.lastInstant - 1 : slotAfter(measured.instants, time);
  add(surfaces, arcsOf(surfaces, *slab.connectivity, topology.reeb, slot));
  return sample;
}

}  // namespace

bool SlabTopologies::isSampled(double time) const {
  return std::ranges::binary_search(times_, time);
}

std::unique_ptr<MeasuredSlab> SlabTopologies::measured(const model::Slab& slab,
                                                       bool sampled) const {
  auto measured = std::make_unique<MeasuredSlab>();
  if (!slab.connectivity) {
    measured->sound = invalid("has no connectivity");
    return measured;
  }
  const auto known = shared(slab);
  if (!known) {
    measured->sound = model::checkConnectivity(*slab.connectivity);
    if (!measured->sound) return measured;
  }
  measured->sound = model::checkSlab(slab);
  if (!measured->sound) return measured;
  measured->topology = known ? known : made(slab);
  measured->instants = instantsOf(measured->topology->reeb, slab);
  if (slab.timeBegin == slab.timeEnd || !sampled) return measured;
  const auto first = std::ranges::lower_bound(times_, slab.timeBegin);
  for (auto at = first; at != times_.end() && *at < slab.timeEnd; ++at) {
    measured->samples.push_back(sampleOf(slab, *measured, *at));
  }
  if (slab.timeEnd == end_ && !times_.empty() && times_.back() == slab.timeEnd) {
    measured->samples.push_back(sampleOf(slab, *measured, slab.timeEnd));
  }
  return measured;
}

std::shared_ptr<const SlabTopology> SlabTopologies::shared(const model::Slab& slab) const {
  std::vector<std::shared_ptr<const SlabTopology>> known;
  {
    const std::scoped_lock lock(mutex_);
    for (const auto& one : shared_) {
      if (one->connectivity == slab.connectivity) known.push_back(one);
    }
  }
  if (known.empty() || slab.vertices.size() != slab.connectivity->vertexCount) return nullptr;
  const auto ranks = ranksOf(slab);
  for (const auto& one : known) {
    if (ranks && one->ranks == ranks->ofInterior) return one;
  }
  return nullptr;
}

std::shared_ptr<const SlabTopology> SlabTopologies::made(const model::Slab& slab) const {
  auto made = std::make_shared<SlabTopology>();
  made->connectivity = slab.connectivity;
  made->reeb = slabReeb(slab);
  if (slab.timeBegin == slab.timeEnd) return made;
  const bool sampled = isSampled(slab.timeBegin);
  auto ranks = ranksOf(slab);
  // Where nothing happens between the layers the order within rounding does not matter.
  if (ranks && !ranks->exact && !made->reeb.between.empty()) ranks.reset();
  if (sampled || ranks) {
    made->atLower = levelSurfaces(slab.connectivity->cells, verticesAfter(slab, slab.timeBegin));
    made->arcsAtLower = arcsOf(made->atLower, *slab.connectivity, made->reeb, 1);
    slice::Cut& cut = made->atLower.cut;
    std::erase_if(cut.triangles, [&](const model::Triangle& triangle) {
      const auto at = [&](int i) { return cut.points[triangle[i]].below; };
      return at(0) == at(1) || at(1) == at(2) || at(2) == at(0);
    });
    cut.cells.clear();
  }
  if (!ranks) return made;
  made->ranks = std::move(ranks->ofInterior);
  // At most two are kept, which alternate where a motion does.
  constexpr std::size_t kMost = 2;
  const std::scoped_lock lock(mutex_);
  if (shared_.size() == kMost) shared_.erase(shared_.begin());
  shared_.push_back(made);
  return made;
}

}  // namespace t4d::measure
