#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "t4d/measure/components.h"
#include "t4d/model/facets.h"
#include "t4d/model/slab.h"

namespace t4d::measure {

enum class Severity : std::uint8_t { Error = 0, Warning = 1, Information = 2, Hint = 3 };

/// One finding. `code` is one of those listed in docs/validate.md and never changes its meaning.
struct Issue {
  std::string code;
  Severity severity = Severity::Error;
  std::string message;                  ///< names the cell, facet or vertex
  std::optional<std::uint64_t> slab;    ///< counted from 0
  std::optional<std::uint64_t> offset;  ///< byte offset in a file, where it comes from one
};

/// Findings, counted all and kept up to a number of each code.
struct IssueList {
  static constexpr std::uint64_t kKeptOfEachCode = 10;

  std::uint64_t errors = 0;
  std::uint64_t warnings = 0;
  std::vector<Issue> issues;

  void add(Issue issue);
  /// `count` findings alike, of which `issue` is the first.
  void add(Issue issue, std::uint64_t count);

 private:
  std::map<std::string, std::uint64_t> kept_;
};

/// What is known of a 4D mesh after all its slabs have been seen.
struct MeshReport {
  std::uint64_t slabs = 0;
  std::uint64_t vertices = 0;  ///< each once, however many slabs hold it
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
  bool vertexLinks = false;  ///< the deep check: every vertex link is a sphere
};

/// Judges a 4D mesh slab by slab, in the memory of two: that each slab is sound by itself
/// (checkSlab), that layers agree bit for bit across seams, that the mesh is closed and oriented;
/// measures it; and on request judges the vertex links. What depends on the connectivity alone is
/// done once for all slabs in a row that share it.
///
/// Findings do not stop it; `put` fails only for a slab that cannot be judged at all.
class MeshChecker : public model::Sink {
 public:
  explicit MeshChecker(CheckOptions options = {});
  ~MeshChecker() override;

  Result<void> put(const model::Slab& slab) override;

  /// The report; the checker is used up.
  MeshReport finish();

 private:
  struct Judged;  // a connectivity and what was found out about it
  struct Seam;    // two of them in a row

  void reportFacets(const std::vector<model::Facet>& facets, const char* where, std::uint64_t slab);
  void judgeSeam(const model::Slab* after, const std::shared_ptr<const Judged>& judgedAfter);
  void compareLayers(const model::Slab& slab);
  void measure(const model::Slab& slab);
  void keepUpperLayer(const model::Slab& slab);

  CheckOptions options_;
  MeshReport report_;
  std::shared_ptr<const Judged> before_;
  std::unique_ptr<Seam> seam_;
  ComponentCounter components_;
  model::Point4 reference_ = model::Point4::Zero();
  double hypervolume24Carry_ = 0;
  double hypervolume24_ = 0;
  std::vector<model::Point4> upperLayer_;
  std::vector<model::Attribute> upperAttributes_;
};

/// The whole of it for a mesh at hand.
Result<MeshReport> checkMesh(const model::Source& source, CheckOptions options = {},
                             const model::Progress& progress = {});

}  // namespace t4d::measure
