#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "measure/cell_quality.h"
#include "model/body.h"
#include "model/slab.h"

namespace t4d::measure {

/// A member of CellQuality.
struct QualityMeasure {
  std::string_view name;  ///< as in JSON and for attributes
  double CellQuality::*value;
};
inline constexpr std::array<QualityMeasure, 6> kQualityMeasures = {
    {{"volume", &CellQuality::volume},
     {"edge_ratio", &CellQuality::edgeRatio},
     {"radius_ratio", &CellQuality::radiusRatio},
     {"smallest_angle", &CellQuality::smallestAngle},
     {"largest_angle", &CellQuality::largestAngle},
     {"height", &CellQuality::height}}};

/// How many cells have which value of a measure. Values are counted in bins of 0.4 per cent, so the
/// memory is that of the powers of two between them, for any number of cells.
class Distribution {
 public:
  Distribution();

  /// `value` is not negative and may be infinite; what is below 2^-1022 counts as 0.
  void add(double value, std::uint64_t count = 1);
  void add(const Distribution& other);

  std::uint64_t count() const { return count_; }
  double min() const { return min_; }  ///< exact; 0 without cells
  double max() const { return max_; }  ///< exact; 0 without cells
  /// The value that the given fraction of the cells does not exceed, to 0.2 per cent.
  double quantile(double fraction) const;
  /// How many values lie between consecutive ones of `edges`, which increase; to 0.2 per cent of
  /// the value.
  std::vector<std::uint64_t> histogram(const std::vector<double>& edges) const;
  /// What is counted, to be put together again by `of`.
  struct Bin {
    std::uint32_t number = 0;
    std::uint64_t count = 0;
  };
  std::vector<Bin> bins() const;
  /// Nothing if there are no such bins.
  static std::optional<Distribution> of(const std::vector<Bin>& bins, double min, double max);

  /// Without what is 0 or infinite, each of the rest to 0.2 per cent.
  Distribution positiveAndFinite() const;

 private:
  /// Calls visit(value, count) for each bin that counts something, in ascending order, until it
  /// returns false.
  template <class Visit>
  void eachBin(Visit visit) const;

  /// The bins of all values with the same exponent; empty where there are none.
  std::vector<std::vector<std::uint64_t>> octaves_;
  std::uint64_t count_ = 0;
  double min_ = 0;
  double max_ = 0;
};

/// A cell and where it is.
struct RankedCell {
  std::size_t body = 0;
  std::uint64_t slab = 0;                        ///< of the body
  std::uint64_t cell = 0;                        ///< of the slab
  model::Point4 center = model::Point4::Zero();  ///< mean of its corners
  CellQuality quality;
};

/// The shape of the cells of a 4D mesh.
struct MeshQuality {
  double timeScale = 0;
  /// Of kQualityMeasures: cells of slabs that last, and of caps.
  std::array<Distribution, kQualityMeasures.size()> sides;
  std::array<Distribution, kQualityMeasures.size()> caps;
  std::uint64_t flat = 0;         ///< cells without volume
  std::vector<RankedCell> worst;  ///< the largest radius ratios, the largest first

  std::uint64_t cells() const { return sides[0].count() + caps[0].count(); }
  Distribution all(std::size_t measure) const;
};

/// How fast the surface of the bodies moves along its normal, in the mean over its area and time:
/// the integral of |n_t| over all cells that last, divided by that of |(n_x, n_y, n_z)|. 0 for
/// bodies at rest.
Result<double> meanNormalSpeed(std::span<const model::Body> bodies,
                               const model::Progress& progress = {});

struct QualityOptions {
  double timeScale = 1;    ///< a length for each unit of time; positive
  std::size_t worst = 10;  ///< how many cells to name
};

/// Measures all cells, slab by slab, on all threads; the result does not depend on their number.
Result<MeshQuality> measureQuality(std::span<const model::Body> bodies,
                                   const QualityOptions& options,
                                   const model::Progress& progress = {});

/// Adds attributes of cells for each of `measures`, as float32, and passes slabs on. Attributes
/// that have their names are replaced.
class QualitySink : public model::Sink {
 public:
  /// `measures` and `next` must outlive the sink.
  QualitySink(std::span<const QualityMeasure> measures, double timeScale, model::Sink& next)
      : measures_(measures), timeScale_(timeScale), next_(next) {}

  Result<void> put(const model::Slab& slab) override;

  /// The names of attributes that were replaced.
  const std::set<std::string>& replaced() const { return replaced_; }

 private:
  void dropNamed(std::vector<model::Attribute>& attributes);

  std::span<const QualityMeasure> measures_;
  double timeScale_;
  model::Sink& next_;
  std::set<std::string> replaced_;
  // The last connectivity, and it without attributes that are replaced.
  std::shared_ptr<const model::Connectivity> given_;
  std::shared_ptr<const model::Connectivity> kept_;
};

}  // namespace t4d::measure
