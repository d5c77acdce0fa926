#pragma once

/// What a 4D mesh is: whether it is valid, how large it and its slices are, what shape its cells
/// have.

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "t4d/mesh.h"
#include "t4d/surface.h"

namespace t4d::measure {

enum class Severity : std::uint8_t { Error = 0, Warning = 1, Information = 2, Hint = 3 };

/// One finding. `code` is one of those listed in docs/validate.md and never changes its meaning.
struct Issue {
  std::string code;
  Severity severity = Severity::Error;
  std::string message;                  ///< names the cell, facet or vertex
  std::optional<std::uint64_t> slab;    ///< counted from 0
  std::optional<std::uint64_t> offset;  ///< byte offset, if the slab comes from a file
};

/// Findings. All are counted; the first kKeptOfEachCode of each code are kept.
struct IssueList {
  static constexpr std::uint64_t kKeptOfEachCode = 10;

  std::uint64_t errors = 0;
  std::uint64_t warnings = 0;
  std::vector<Issue> issues;

  void add(Issue issue);
  /// `count` findings of one kind, of which `issue` is the first.
  void add(Issue issue, std::uint64_t count);
  /// Findings of the slabs that follow.
  void add(const IssueList& after);

 private:
  std::map<std::string, std::uint64_t> kept_;
};

/// Result of checking a whole 4D mesh.
struct MeshReport {
  std::uint64_t slabs = 0;
  std::uint64_t vertices = 0;  ///< each counted once, even if two slabs have it
  std::uint64_t tetrahedra = 0;
  model::TimeSpan time;
  model::Bounds4 bounds;

  bool closed = true;         ///< every facet has exactly two cells
  bool oriented = true;       ///< on opposite sides
  double hypervolume = 0;     ///< enclosed, in length^3 * time; the sum of det[a,b,c,d]/24
  double boundaryVolume = 0;  ///< 3-measure of all cells, taking one time unit as one length unit
  std::uint64_t components = 0;
  std::uint64_t degenerateCells = 0;
  std::optional<bool> vertexLinksOk;  ///< with CheckOptions::vertexLinks

  IssueList issues;

  bool valid() const { return issues.errors == 0; }
};

struct CheckOptions {
  bool vertexLinks = false;  ///< the deep check: every vertex is manifold
  /// The slabs are a part of a mesh, which goes on before the first or after the last of them: that
  /// layer is open, and what they enclose may be negative.
  bool goesOnBefore = false;
  bool goesOnAfter = false;
};

struct PartOfMesh;

/// Checks and measures a 4D mesh slab by slab, with two in memory: that each slab is valid on its
/// own (checkSlab), that layers are equal (`==`) across seams, that the mesh is closed and oriented
/// and, on request, that it is manifold at every vertex. Checks that depend on the connectivity
/// alone are done once for consecutive slabs that share it.
///
/// Findings do not stop the check; `put` fails only for a slab that cannot be checked at all.
class MeshChecker : public model::Sink {
 public:
  explicit MeshChecker(CheckOptions options = {});
  ~MeshChecker() override;

  Result<void> put(const model::Slab& slab) override;
  std::unique_ptr<Prepared> prepare(const model::Slab& slab) const override;
  Result<void> putPrepared(const model::Slab& slab, Prepared* prepared) override;

  /// Call it before the first slab of a part: `slab` is the one before it, which has this number,
  /// and is not counted. The layer between them is checked, and slabs have their numbers in the
  /// mesh.
  Result<void> startAfter(const model::Slab& slab, std::uint64_t number);

  /// The report. Call it once, after the last slab.
  MeshReport finish();
  /// The report on a part of the mesh (mesh_parts.h). Call it once, in place of `finish`. If
  /// startAfter was called, CheckOptions::goesOnBefore must be set.
  PartOfMesh finishPart();

 private:
  class State;
  std::unique_ptr<State> state_;
};

/// Checks all slabs of a source.
Result<MeshReport> checkMesh(const model::Source& source, CheckOptions options = {},
                             const model::Progress& progress = {});

/// What a solid at one time is, in length units; exact but for rounding. Of nothing, all is 0.
struct SolidMeasures {
  double time = 0;
  double volume = 0;
  double area = 0;
  model::Point3 centroid = model::Point3::Zero();
  std::uint64_t components = 0;  ///< connected surfaces that face outward
  std::uint64_t cavities = 0;    ///< those that face inward
  /// Sum of those of all surfaces (generaOf): the number of handles.
  double genus = 0;
  model::Bounds3 bounds = {};  ///< empty() of nothing

  /// Adds another solid at the same time, which counts as apart from this one.
  void add(const SolidMeasures& other);
};

/// Of a closed triangle mesh that faces outward; `time` is 0.
SolidMeasures measuresOf(const model::TriangleMesh& mesh);

/// Each body at each of `times`, which may be in any order; that of nothing when it does not exist.
/// Several times are sliced at once, one on each thread, which has a slab in memory. Fails for a
/// time before the first body or after the last, and if slicing does.
Result<std::vector<std::vector<SolidMeasures>>> measuresOfEach(
    std::span<const model::Body> bodies, std::span<const double> times,
    const model::Progress& progress = {});

/// The solids of several bodies at the same times as one (SolidMeasures::add).
std::vector<SolidMeasures> addedUp(std::span<const std::vector<SolidMeasures>> bodies);

/// Both: the solid of all bodies that exist at each of `times`.
Result<std::vector<SolidMeasures>> measuresAt(std::span<const model::Body> bodies,
                                              std::span<const double> times,
                                              const model::Progress& progress = {});

/// The shape of a tetrahedron in R^4, measured within its own three dimensions. The best
/// tetrahedron is the regular one; what each measure is of it stands in brackets. A flat cell has
/// infinite ratios, angles of 0 and 180 degrees and no height.
struct CellQuality {
  double volume = 0;         ///< 3-measure, in length^3
  double edgeRatio = 0;      ///< longest edge divided by the shortest [1]
  double radiusRatio = 0;    ///< radius of the circumsphere, divided by three inradii [1]
  double smallestAngle = 0;  ///< between two sides, in degrees [70.53]
  double largestAngle = 0;   ///< between two sides, in degrees [70.53]
  double height = 0;         ///< the smallest height, divided by the longest edge [0.8165]
};

/// Measures a tetrahedron after its times have been multiplied by `timeScale`, a length for each
/// unit of time.
CellQuality qualityOf(const std::array<model::Point4, 4>& corners, double timeScale);

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
