#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "measure/components.h"
#include "model/orderless_sum.h"
#include "model/slab.h"

namespace t4d::model {
struct Facet;
}

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

/// What is found in some consecutive slabs of a mesh, which adds up to what is found in all of
/// them.
struct PartOfMesh {
  MeshReport found;  ///< without what follows, and `components`
  model::OrderlessSum hypervolume;
  model::OrderlessSum hypervolumeMagnitude;  ///< of the slabs, each taken as positive
  model::OrderlessSum boundaryVolume;
  bool hasPositive = false;  ///< a slab of positive hypervolume
  bool hasNegative = false;
  ComponentSpan components;
};

/// The report on a mesh of which these are the parts, in order, the first of which begins it and
/// the last of which ends it: bit for bit that of checkMesh. Fails if the parts do not follow one
/// another.
Result<MeshReport> joinedReport(const std::vector<PartOfMesh>& parts);

struct CheckOptions {
  bool vertexLinks = false;  ///< the deep check: every vertex is manifold
  /// The slabs are a part of a mesh, which goes on before the first or after the last of them: that
  /// layer is open, and what they enclose may be negative.
  bool goesOnBefore = false;
  bool goesOnAfter = false;
};

struct SlabMeasure;

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
  /// The report on a part of the mesh. Call it once, in place of `finish`. If startAfter was
  /// called, CheckOptions::goesOnBefore must be set.
  PartOfMesh finishPart();

 private:
  struct Checked;   // a connectivity and what was found in it
  struct Seam;      // two consecutive ones
  struct Measured;  // a slab, prepared
  struct Shared;    // what slabs that are prepared at the same time share
  using CheckedPointer = std::shared_ptr<const Checked>;

  Result<Checked> check(const std::shared_ptr<const model::Connectivity>& connectivity) const;
  void reportFacets(const std::vector<model::Facet>& facets, const char* where, std::uint64_t slab);
  void checkSeam(const model::Slab* after, const CheckedPointer& checkedAfter);
  void reportNonManifold(const Checked& checked, const model::Slab& slab);
  void compareLayers(const model::Slab& slab);
  void add(const SlabMeasure& measured, const model::Slab& slab);
  void keepUpperLayer(const model::Slab& slab);

  CheckOptions options_;
  PartOfMesh part_;
  MeshReport& report_ = part_.found;
  std::uint64_t number_ = 0;  // of the next slab
  std::unique_ptr<Shared> shared_;
  CheckedPointer before_;
  std::unique_ptr<Seam> seam_;
  ComponentCounter components_;
  std::vector<model::Point4> upperLayer_;
  std::vector<model::Attribute> upperAttributes_;
};

/// Checks all slabs of a source.
Result<MeshReport> checkMesh(const model::Source& source, CheckOptions options = {},
                             const model::Progress& progress = {});

}  // namespace t4d::measure
