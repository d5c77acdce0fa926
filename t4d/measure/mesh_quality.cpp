#include "t4d/measure/mesh_quality.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <tuple>

#include <tbb/combinable.h>
#include <tbb/parallel_for.h>

namespace t4d::measure {
namespace {

// A bin holds numbers that agree in sign, exponent and the first eight bits after it.
constexpr int kBitsAfterExponent = 8;
constexpr int kShift = 52 - kBitsAfterExponent;
constexpr std::uint64_t kExponents = 128;  // 2^-64 to 2^64; the ends take what is beyond
constexpr std::uint64_t kFirstBin = (std::uint64_t{1023 - 64}) << kBitsAfterExponent;
constexpr std::uint64_t kBins = kExponents << kBitsAfterExponent;

double middleOf(std::uint64_t bin) {
  return std::bit_cast<double>((kFirstBin + bin) << kShift | std::uint64_t{1} << (kShift - 1));
}

std::array<model::Point4, 4> cornersOf(const model::Slab& slab, const model::Cell& cell) {
  return {slab.vertices[cell[0]], slab.vertices[cell[1]], slab.vertices[cell[2]],
          slab.vertices[cell[3]]};
}

/// Larger ratios first; equal ones as in the file.
bool isWorse(const RankedCell& a, const RankedCell& b) {
  if (a.quality.radiusRatio != b.quality.radiusRatio) {
    return a.quality.radiusRatio > b.quality.radiusRatio;
  }
  return std::tie(a.body, a.slab, a.cell) < std::tie(b.body, b.slab, b.cell);
}

/// What a thread has found.
struct Tally {
  std::array<Distribution, kQualityMeasures.size()> sides;
  std::array<Distribution, kQualityMeasures.size()> caps;
  std::uint64_t flat = 0;
  std::vector<RankedCell> worst;  // a heap, the best of them first

  void rank(const RankedCell& cell, std::size_t most) {
    if (most == 0 || (worst.size() == most && !isWorse(cell, worst.front()))) return;
    worst.push_back(cell);
    std::ranges::push_heap(worst, isWorse);
    if (worst.size() <= most) return;
    std::ranges::pop_heap(worst, isWorse);
    worst.pop_back();
  }
};

constexpr std::size_t kPiece = 16384;  // cells of a task

/// Calls visit(body, slab number, slab) for each slab.
template <class Visit>
Result<void> eachSlab(std::span<const model::Body> bodies, const model::Progress& progress,
                      Visit visit) {
  struct Visitor : model::Sink {
    Visitor(const Visit& visit, std::size_t body) : visit(visit), body(body) {}
    Result<void> put(const model::Slab& slab) override {
      visit(body, number++, slab);
      return {};
    }
    const Visit& visit;
    std::size_t body;
    std::size_t number = 0;
  };
  std::size_t all = 0;
  std::size_t before = 0;
  for (const model::Body& body : bodies) all += body.source->slabCount();
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const std::size_t here = bodies[b].source->slabCount();
    const auto ofAll = [&](double fraction) {
      progress((static_cast<double>(before) + fraction * static_cast<double>(here)) /
               static_cast<double>(all));
    };
    Visitor visitor(visit, b);
    auto done = model::pump(*bodies[b].source, visitor, progress ? ofAll : model::Progress());
    if (!done) return done;
    before += here;
  }
  return {};
}

}  // namespace

Distribution::Distribution() : bins_(kBins) {}

void Distribution::add(double value) {
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(value) >> kShift;
  ++bins_[std::clamp(bits, kFirstBin, kFirstBin + kBins - 1) - kFirstBin];
  min_ = count_ == 0 ? value : std::min(min_, value);
  max_ = count_ == 0 ? value : std::max(max_, value);
  ++count_;
}

void Distribution::add(const Distribution& other) {
  if (other.count_ == 0) return;
  for (std::size_t i = 0; i < bins_.size(); ++i) bins_[i] += other.bins_[i];
  min_ = count_ == 0 ? other.min_ : std::min(min_, other.min_);
  max_ = count_ == 0 ? other.max_ : std::max(max_, other.max_);
  count_ += other.count_;
}

double Distribution::quantile(double fraction) const {
  if (count_ == 0) return 0;
  const double wanted = fraction * static_cast<double>(count_);
  std::uint64_t below = 0;
  std::uint64_t bin = 0;
  for (; bin + 1 < kBins; ++bin) {
    below += bins_[bin];
    if (below > 0 && static_cast<double>(below) >= wanted) break;
  }
  // The end bins also hold what is beyond them.
  if (bin == 0) return min_;
  if (bin + 1 == kBins) return max_;
  return std::clamp(middleOf(bin), min_, max_);
}

std::vector<std::uint64_t> Distribution::histogram(const std::vector<double>& edges) const {
  std::vector<std::uint64_t> counts(edges.empty() ? 0 : edges.size() - 1);
  for (std::uint64_t bin = 0; bin < kBins; ++bin) {
    if (bins_[bin] == 0) continue;
    const double value = std::clamp(middleOf(bin), min_, max_);
    const auto after = std::ranges::upper_bound(edges, value);
    if (after == edges.begin()) continue;
    // The last edge belongs to the last interval.
    const auto index = static_cast<std::size_t>(after - edges.begin()) - 1;
    if (index < counts.size()) {
      counts[index] += bins_[bin];
    } else if (!counts.empty() && value == edges.back()) {
      counts.back() += bins_[bin];
    }
  }
  return counts;
}

Distribution MeshQuality::all(std::size_t measure) const {
  Distribution both = sides[measure];
  both.add(caps[measure]);
  return both;
}

Result<double> meanNormalSpeed(std::span<const model::Body> bodies,
                               const model::Progress& progress) {
  double alongTime = 0;
  double inSpace = 0;
  const auto add = [&](std::size_t, std::size_t, const model::Slab& slab) {
    if (!(slab.timeEnd > slab.timeBegin)) return;
    const std::vector<model::Cell>& cells = slab.connectivity->cells;
    // Sums of fixed pieces do not depend on the number of threads.
    std::vector<std::array<double, 2>> pieces((cells.size() + kPiece - 1) / kPiece);
    tbb::parallel_for(std::size_t{0}, pieces.size(), [&](std::size_t piece) {
      const std::size_t end = std::min(cells.size(), (piece + 1) * kPiece);
      for (std::size_t i = piece * kPiece; i < end; ++i) {
        const auto corners = cornersOf(slab, cells[i]);
        Eigen::Matrix<double, 4, 3> edges;
        for (int k = 0; k < 3; ++k) edges.col(k) = corners[k + 1] - corners[0];
        const Eigen::Vector3d u = edges.col(0).head<3>();
        const Eigen::Vector3d v = edges.col(1).head<3>();
        const Eigen::Vector3d w = edges.col(2).head<3>();
        // The normal, of six times the cell's measure: its part in time, then in space.
        pieces[piece][0] += std::abs(u.cross(v).dot(w));
        pieces[piece][1] +=
            (edges(3, 0) * v.cross(w) + edges(3, 1) * w.cross(u) + edges(3, 2) * u.cross(v)).norm();
      }
    });
    for (const auto& [time, space] : pieces) {
      alongTime += time;
      inSpace += space;
    }
  };
  if (auto done = eachSlab(bodies, progress, add); !done) return pass(done.error());
  return inSpace > 0 ? alongTime / inSpace : 0;
}

Result<MeshQuality> measureQuality(std::span<const model::Body> bodies,
                                   const QualityOptions& options, const model::Progress& progress) {
  tbb::combinable<Tally> tallies;
  const auto add = [&](std::size_t body, std::size_t number, const model::Slab& slab) {
    const std::vector<model::Cell>& cells = slab.connectivity->cells;
    const std::size_t pieces = (cells.size() + kPiece - 1) / kPiece;
    tbb::parallel_for(std::size_t{0}, pieces, [&](std::size_t piece) {
      Tally& tally = tallies.local();
      auto& distributions = slab.timeEnd > slab.timeBegin ? tally.sides : tally.caps;
      const std::size_t end = std::min(cells.size(), (piece + 1) * kPiece);
      for (std::size_t i = piece * kPiece; i < end; ++i) {
        const auto corners = cornersOf(slab, cells[i]);
        RankedCell cell{body, number, i, {}, qualityOf(corners, options.timeScale)};
        for (std::size_t k = 0; k < kQualityMeasures.size(); ++k) {
          distributions[k].add(cell.quality.*kQualityMeasures[k].value);
        }
        if (!(cell.quality.volume > 0)) ++tally.flat;
        cell.center = (corners[0] + corners[1] + corners[2] + corners[3]) / 4;
        tally.rank(cell, options.worst);
      }
    });
  };
  if (auto done = eachSlab(bodies, progress, add); !done) return pass(done.error());
  Tally sum;
  tallies.combine_each([&](const Tally& tally) {
    for (std::size_t k = 0; k < kQualityMeasures.size(); ++k) {
      sum.sides[k].add(tally.sides[k]);
      sum.caps[k].add(tally.caps[k]);
    }
    sum.flat += tally.flat;
    for (const RankedCell& cell : tally.worst) sum.rank(cell, options.worst);
  });
  std::ranges::sort(sum.worst, isWorse);
  return MeshQuality{options.timeScale, std::move(sum.sides), std::move(sum.caps), sum.flat,
                     std::move(sum.worst)};
}

void QualitySink::dropNamed(std::vector<model::Attribute>& attributes) {
  std::erase_if(attributes, [&](const model::Attribute& attribute) {
    const bool named = std::ranges::any_of(
        measures_, [&](const QualityMeasure& one) { return one.name == attribute.name; });
    if (named) replaced_.insert(attribute.name);
    return named;
  });
}

Result<void> QualitySink::put(const model::Slab& slab) {
  if (slab.connectivity != given_) {
    model::Connectivity kept = *slab.connectivity;
    const std::size_t before = kept.cellAttributes.size();
    dropNamed(kept.cellAttributes);
    given_ = slab.connectivity;
    kept_ = kept.cellAttributes.size() == before
                ? given_
                : std::make_shared<const model::Connectivity>(std::move(kept));
  }
  const std::vector<model::Cell>& cells = slab.connectivity->cells;
  std::vector<std::vector<float>> columns(measures_.size(), std::vector<float>(cells.size()));
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cells.size(), kPiece),
                    [&](const tbb::blocked_range<std::size_t>& some) {
                      for (std::size_t i = some.begin(); i < some.end(); ++i) {
                        const CellQuality quality =
                            qualityOf(cornersOf(slab, cells[i]), timeScale_);
                        for (std::size_t k = 0; k < measures_.size(); ++k) {
                          columns[k][i] = static_cast<float>(quality.*measures_[k].value);
                        }
                      }
                    });
  model::Slab with = slab;
  with.connectivity = kept_;
  dropNamed(with.attributes);
  for (std::size_t k = 0; k < measures_.size(); ++k) {
    with.attributes.push_back(
        model::makeAttribute(std::string(measures_[k].name), model::Domain::Cell, columns[k]));
  }
  return next_.put(with);
}

}  // namespace t4d::measure
