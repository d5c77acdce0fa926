#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <tuple>
#include <type_traits>

#include "measure/cell_quality.h"
#include "model/parallel.h"
#include "model/progress.h"
#include "model/unit_scale.h"

namespace t4d::measure {
namespace {

// A bin holds numbers that agree in exponent and the first eight bits after it.
constexpr int kBitsAfterExponent = 8;
constexpr int kShift = 52 - kBitsAfterExponent;
constexpr std::size_t kBinsOfOctave = std::size_t{1} << kBitsAfterExponent;
constexpr std::size_t kOctaves = 2048;  // the first has 0, the last infinity

/// The middle of a bin.
double valueOf(std::size_t octave, std::size_t bin) {
  if (octave == 0) return 0;
  if (octave == kOctaves - 1) return std::numeric_limits<double>::infinity();
  const std::uint64_t first = std::uint64_t{octave} << kBitsAfterExponent | bin;
  return std::bit_cast<double>(first << kShift | std::uint64_t{1} << (kShift - 1));
}

std::array<model::Point4, 4> cornersOf(const model::Slab& slab, const model::Cell& cell) {
  return {slab.vertices[cell[0]], slab.vertices[cell[1]], slab.vertices[cell[2]],
          slab.vertices[cell[3]]};
}

/// Calls visit(number, corners, quality) for the cells `begin` to `end` of a slab, in order.
template <class Visit>
void eachQuality(const model::Slab& slab, double timeScale, std::size_t begin, std::size_t end,
                 const Visit& visit) {
  const std::vector<model::Cell>& cells = slab.connectivity->cells;
  for (std::size_t first = begin; first < end; first += kCellsTogether) {
    CellsTogether corners;
    for (std::size_t k = 0; k < kCellsTogether; ++k) {
      corners[k] = cornersOf(slab, cells[std::min(first + k, end - 1)]);
    }
    const auto qualities = qualitiesOf(corners, timeScale);
    const std::size_t count = std::min(kCellsTogether, end - first);
    for (std::size_t k = 0; k < count; ++k) visit(first + k, corners[k], qualities[k]);
  }
}

/// Larger ratios first; equal ones as in the file.
bool isWorse(const RankedCell& a, const RankedCell& b) {
  if (a.quality.radiusRatio != b.quality.radiusRatio) {
    return a.quality.radiusRatio > b.quality.radiusRatio;
  }
  return std::tie(a.body, a.slab, a.cell) < std::tie(b.body, b.slab, b.cell);
}

/// The worst of some cells.
class Worst {
 public:
  explicit Worst(std::size_t most) : most_(most) {}

  void add(const RankedCell& cell) {
    if (most_ == 0 || (cells_.size() == most_ && !isWorse(cell, cells_.front()))) return;
    cells_.push_back(cell);
    std::ranges::push_heap(cells_, isWorse);
    if (cells_.size() <= most_) return;
    std::ranges::pop_heap(cells_, isWorse);
    cells_.pop_back();
  }
  const std::vector<RankedCell>& cells() const { return cells_; }
  std::vector<RankedCell> sorted() && {
    std::ranges::sort(cells_, isWorse);
    return std::move(cells_);
  }

 private:
  std::size_t most_;
  std::vector<RankedCell> cells_;  // a heap, the best of them first
};

/// The counts of one thread.
struct Tally {
  std::array<Distribution, kQualityMeasures.size()> sides;
  std::array<Distribution, kQualityMeasures.size()> caps;
  std::uint64_t flat = 0;
};

/// How large the volume of a parallelepiped can be by rounding alone, if its corners are rounded
/// and lie in a plane.
double roundingOfVolume(const std::array<model::Point4, 4>& corners, const Eigen::Vector3d& u,
                        const Eigen::Vector3d& v, const Eigen::Vector3d& w) {
  double largest = 0;
  for (const model::Point4& corner : corners) {
    largest = std::max(largest, corner.head<3>().cwiseAbs().maxCoeff());
  }
  constexpr double kRounding = 16 * std::numeric_limits<double>::epsilon();
  const double sides = u.norm() * v.norm() + v.norm() * w.norm() + w.norm() * u.norm();
  return kRounding * largest * sides;
}

constexpr std::size_t kPiece = 16384;  // cells of a task

/// Calls take(body, slab number, item) for each slab in order, with what `make` has made of it, for
/// several slabs at once.
template <class Make, class Take>
Result<void> eachSlab(std::span<const model::Body> bodies, const model::Progress& progress,
                      const Make& make, const Take& take) {
  struct Visitor : model::Sink {
    struct Made : Prepared {
      explicit Made(const Make& make, const model::Slab& slab) : item(make(slab)) {}
      std::invoke_result_t<Make, const model::Slab&> item;
    };
    Visitor(const Make& make, const Take& take, std::size_t body)
        : make(make), take(take), body(body) {}
    Result<void> put(const model::Slab& slab) override {
      return putPrepared(slab, prepare(slab).get());
    }
    std::unique_ptr<Prepared> prepare(const model::Slab& slab) const override {
      return std::make_unique<Made>(make, slab);
    }
    Result<void> putPrepared(const model::Slab& /*slab*/, Prepared* made) override {
      take(body, number++, static_cast<Made*>(made)->item);
      return {};
    }
    const Make& make;
    const Take& take;
    std::size_t body;
    std::size_t number = 0;
  };
  std::size_t all = 0;
  std::size_t before = 0;
  for (const model::Body& body : bodies) all += body.source->slabCount();
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const std::size_t here = bodies[b].source->slabCount();
    const auto share = [&](std::size_t slabs) { return double(slabs) / double(all); };
    Visitor visitor(make, take, b);
    auto done = model::pump(*bodies[b].source, visitor,
                            model::partOf(progress, share(before), share(before + here)));
    if (!done) return done;
    before += here;
  }
  return {};
}

}  // namespace

Distribution::Distribution() : octaves_(kOctaves) {}

template <class Visit>
void Distribution::eachBin(Visit visit) const {
  for (std::size_t octave = 0; octave < kOctaves; ++octave) {
    for (std::size_t bin = 0; bin < octaves_[octave].size(); ++bin) {
      const std::uint64_t count = octaves_[octave][bin];
      if (count == 0) continue;
      if (!visit(std::clamp(valueOf(octave, bin), min_, max_), count)) return;
    }
  }
}

void Distribution::add(double value, std::uint64_t count) {
  const std::uint64_t bin = std::bit_cast<std::uint64_t>(value) >> kShift;
  std::vector<std::uint64_t>& octave = octaves_[(bin >> kBitsAfterExponent) % kOctaves];
  octave.resize(kBinsOfOctave);
  octave[bin % kBinsOfOctave] += count;
  min_ = count_ == 0 ? value : std::min(min_, value);
  max_ = count_ == 0 ? value : std::max(max_, value);
  count_ += count;
}

void Distribution::add(const Distribution& other) {
  if (other.count_ == 0) return;
  for (std::size_t octave = 0; octave < kOctaves; ++octave) {
    const std::vector<std::uint64_t>& more = other.octaves_[octave];
    octaves_[octave].resize(std::max(octaves_[octave].size(), more.size()));
    for (std::size_t i = 0; i < more.size(); ++i) octaves_[octave][i] += more[i];
  }
  min_ = count_ == 0 ? other.min_ : std::min(min_, other.min_);
  max_ = count_ == 0 ? other.max_ : std::max(max_, other.max_);
  count_ += other.count_;
}

double Distribution::quantile(double fraction) const {
  const double wanted = fraction * static_cast<double>(count_);
  std::uint64_t below = 0;
  double found = 0;
  eachBin([&](double value, std::uint64_t count) {
    below += count;
    found = value;
    return static_cast<double>(below) < wanted;
  });
  return found;
}

std::vector<std::uint64_t> Distribution::histogram(const std::vector<double>& edges) const {
  std::vector<std::uint64_t> counts(edges.empty() ? 0 : edges.size() - 1);
  eachBin([&](double value, std::uint64_t count) {
    const auto after = std::ranges::upper_bound(edges, value);
    if (after == edges.begin()) return true;
    // The last edge belongs to the last interval.
    const auto index = static_cast<std::size_t>(after - edges.begin()) - 1;
    if (index < counts.size()) {
      counts[index] += count;
    } else if (!counts.empty() && value == edges.back()) {
      counts.back() += count;
    }
    return true;
  });
  return counts;
}

std::vector<Distribution::Bin> Distribution::bins() const {
  std::vector<Bin> bins;
  for (std::size_t octave = 0; octave < kOctaves; ++octave) {
    for (std::size_t bin = 0; bin < octaves_[octave].size(); ++bin) {
      const std::uint64_t count = octaves_[octave][bin];
      if (count > 0) {
        bins.push_back({static_cast<std::uint32_t>(octave << kBitsAfterExponent | bin), count});
      }
    }
  }
  return bins;
}

std::optional<Distribution> Distribution::of(const std::vector<Bin>& bins, double min, double max) {
  Distribution made;
  for (const auto& [number, count] : bins) {
    if (number >> kBitsAfterExponent >= kOctaves) return std::nullopt;
    std::vector<std::uint64_t>& octave = made.octaves_[number >> kBitsAfterExponent];
    octave.resize(kBinsOfOctave);
    octave[number % kBinsOfOctave] += count;
    made.count_ += count;
  }
  made.min_ = min;
  made.max_ = max;
  return made;
}

Distribution Distribution::positiveAndFinite() const {
  Distribution some;
  eachBin([&](double value, std::uint64_t count) {
    if (value > 0 && std::isfinite(value)) some.add(value, count);
    return true;
  });
  return some;
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
  std::vector<const model::Source*> sources;
  for (const model::Body& body : bodies) sources.push_back(body.source);
  const auto scale = model::spaceScaleOf(sources);
  if (!scale) return scale.error();
  using Pieces = std::vector<std::array<double, 2>>;
  const auto piecesOf = [&](const model::Slab& slab) {
    if (!(slab.timeEnd > slab.timeBegin)) return Pieces();
    const std::vector<model::Cell>& cells = slab.connectivity->cells;
    // Sums of fixed pieces do not depend on the number of threads.
    Pieces pieces((cells.size() + kPiece - 1) / kPiece);
    model::forEach(pieces.size(), [&](std::size_t piece) {
      const std::size_t end = std::min(cells.size(), (piece + 1) * kPiece);
      for (std::size_t i = piece * kPiece; i < end; ++i) {
        auto corners = cornersOf(slab, cells[i]);
        for (model::Point4& corner : corners) {
          corner.head<3>() = scale->toUnit(model::Point3(corner.head<3>()));
        }
        Eigen::Matrix<double, 4, 3> edges;
        for (int k = 0; k < 3; ++k) edges.col(k) = corners[k + 1] - corners[0];
        const Eigen::Vector3d u = edges.col(0).head<3>();
        const Eigen::Vector3d v = edges.col(1).head<3>();
        const Eigen::Vector3d w = edges.col(2).head<3>();
        // The normal, of six times the cell's measure: its part in time, then in space.
        const double inTime = std::abs(u.cross(v).dot(w));
        if (inTime > roundingOfVolume(corners, u, v, w)) pieces[piece][0] += inTime;
        pieces[piece][1] +=
            (edges(3, 0) * v.cross(w) + edges(3, 1) * w.cross(u) + edges(3, 2) * u.cross(v)).norm();
      }
    });
    return pieces;
  };
  const auto add = [&](std::size_t, std::size_t, const Pieces& pieces) {
    for (const auto& [time, space] : pieces) {
      alongTime += time;
      inSpace += space;
    }
  };
  if (auto done = eachSlab(bodies, progress, piecesOf, add); !done) return done.error();
  return inSpace > 0 ? scale->fromUnit(alongTime / inSpace) : 0;
}

Result<MeshQuality> measureQuality(std::span<const model::Body> bodies,
                                   const QualityOptions& options, const model::Progress& progress) {
  // Counts, which may be added in any order.
  model::PerThread<Tally> tallies;
  const auto worstOf = [&](const model::Slab& slab) {
    const std::vector<model::Cell>& cells = slab.connectivity->cells;
    std::vector<Worst> worst((cells.size() + kPiece - 1) / kPiece, Worst(options.worst));
    model::forEach(worst.size(), [&](std::size_t piece) {
      Tally& tally = tallies.local();
      auto& distributions = slab.timeEnd > slab.timeBegin ? tally.sides : tally.caps;
      const std::size_t end = std::min(cells.size(), (piece + 1) * kPiece);
      const auto count = [&](std::size_t i, const auto& corners, const CellQuality& quality) {
        for (std::size_t k = 0; k < kQualityMeasures.size(); ++k) {
          distributions[k].add(quality.*kQualityMeasures[k].value);
        }
        if (std::isinf(quality.radiusRatio)) ++tally.flat;
        const model::Point4 center = (corners[0] + corners[1] + corners[2] + corners[3]) / 4;
        worst[piece].add({0, 0, i, center, quality});
      };
      eachQuality(slab, options.timeScale, piece * kPiece, end, count);
    });
    return worst;
  };
  Worst worst(options.worst);
  const auto add = [&](std::size_t body, std::size_t number, const std::vector<Worst>& ofSlab) {
    for (const Worst& piece : ofSlab) {
      for (RankedCell cell : piece.cells()) {
        cell.body = body;
        cell.slab = number;
        worst.add(cell);
      }
    }
  };
  if (auto done = eachSlab(bodies, progress, worstOf, add); !done) return done.error();
  Tally sum;
  tallies.each([&](const Tally& tally) {
    for (std::size_t k = 0; k < kQualityMeasures.size(); ++k) {
      sum.sides[k].add(tally.sides[k]);
      sum.caps[k].add(tally.caps[k]);
    }
    sum.flat += tally.flat;
  });
  return MeshQuality{options.timeScale, std::move(sum.sides), std::move(sum.caps), sum.flat,
                     std::move(worst).sorted()};
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
  model::forRanges(0, cells.size(), kPiece, [&](std::size_t begin, std::size_t end) {
    const auto set = [&](std::size_t i, const auto& /*corners*/, const CellQuality& quality) {
      for (std::size_t k = 0; k < measures_.size(); ++k) {
        columns[k][i] = static_cast<float>(quality.*measures_[k].value);
      }
    };
    eachQuality(slab, timeScale_, begin, end, set);
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
