#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include <fmt/format.h>

#include "measure/components.h"
#include "measure/mesh_parts.h"
#include "measure/slab_measure.h"
#include "measure/vertex_links.h"
#include "model/facets.h"
#include "model/parallel.h"
#include "model/shared_parts.h"
#include "t4d/check.h"

namespace t4d::measure {

void IssueList::add(Issue issue) { add(std::move(issue), 1); }

void IssueList::add(Issue issue, std::uint64_t count) {
  if (issue.severity == Severity::Error) errors += count;
  if (issue.severity == Severity::Warning) warnings += count;
  if (kept_[issue.code]++ < kKeptOfEachCode) issues.push_back(std::move(issue));
}

void IssueList::add(const IssueList& after) {
  errors += after.errors;
  warnings += after.warnings;
  for (const Issue& issue : after.issues) {
    if (kept_[issue.code]++ < kKeptOfEachCode) issues.push_back(issue);
  }
}

class MeshChecker::State {
 public:
  explicit State(CheckOptions options);

  std::unique_ptr<Prepared> prepare(const model::Slab& slab) const;
  Result<void> putPrepared(const model::Slab& slab, Prepared* prepared);
  Result<void> startAfter(const model::Slab& slab, std::uint64_t number);
  MeshReport finish();
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

struct MeshChecker::State::Checked {
  std::shared_ptr<const model::Connectivity> connectivity;
  model::FacetTopology facets;
  Components components;
  std::vector<std::uint32_t> nonManifold;  // interior vertices
};

struct MeshChecker::State::Seam {
  CheckedPointer before;
  CheckedPointer after;
  std::vector<model::Facet> unmatched;
  std::vector<std::uint32_t> nonManifold;
};

struct MeshChecker::State::Measured : Prepared {
  Result<CheckedPointer> checked;
  model::Bounds4 bounds;
  SlabMeasure measure;
};

struct MeshChecker::State::Shared {
  model::SharedParts<const model::Connectivity*, Checked> checked;
};

MeshChecker::State::State(CheckOptions options)
    : options_(options), shared_(std::make_unique<Shared>()), seam_(std::make_unique<Seam>()) {
  if (options_.vertexLinks) report_.vertexLinksOk = true;
  if (options_.goesOnBefore || options_.goesOnAfter) components_.trackSpan();
}

Result<MeshChecker::State::Checked> MeshChecker::State::check(
    const std::shared_ptr<const model::Connectivity>& connectivity) const {
  if (auto sound = model::checkConnectivity(*connectivity); !sound) return sound.error();
  Checked checked;
  checked.connectivity = connectivity;
  model::together([&] { checked.facets = model::facetTopology(*connectivity); },
                  [&] {
                    if (options_.vertexLinks) {
                      checked.nonManifold = nonManifoldInteriorVertices(*connectivity);
                    }
                  },
                  [&] { checked.components = componentsOf(*connectivity); });
  return checked;
}

std::unique_ptr<model::Sink::Prepared> MeshChecker::State::prepare(const model::Slab& slab) const {
  auto prepared = std::make_unique<Measured>();
  if (!slab.connectivity) {
    prepared->checked = invalid("has no connectivity");
    return prepared;
  }
  prepared->checked =
      shared_->checked.get(slab.connectivity.get(), [&] { return check(slab.connectivity); });
  if (!prepared->checked) return prepared;
  if (auto sound = model::checkSlab(slab); !sound) {
    prepared->checked = sound.error();
    return prepared;
  }
  model::Bounds4& bounds = prepared->bounds;
  for (const model::Point4& vertex : slab.vertices) bounds.add(vertex);
  // A cell's volume is known up to a few units in the last place of its corners.
  const model::Point4 rounding = 4 * std::numeric_limits<double>::epsilon() *
                                 bounds.min.cwiseAbs().cwiseMax(bounds.max.cwiseAbs());
  prepared->measure = measureOf(slab, rounding);
  return prepared;
}

Result<void> MeshChecker::State::putPrepared(const model::Slab& slab, Prepared* prepared) {
  auto& [found, bounds, measured] = static_cast<Measured&>(*prepared);
  if (!found) return invalid(found.error().message, placeIn({}, fmt::format("slab {}", number_)));
  const CheckedPointer& checked = *found;
  const model::Connectivity& connectivity = *slab.connectivity;
  report_.bounds.add(bounds);
  reportFacets(checked->facets.unmatched, "in the slab", number_);
  reportNonManifold(*checked, slab);
  checkSeam(&slab, checked);
  components_.add(checked->components, connectivity.lowerCount, connectivity.upperCount);
  add(measured, slab);

  report_.vertices += connectivity.vertexCount - (before_ ? connectivity.lowerCount : 0);
  report_.tetrahedra += connectivity.cells.size();
  if (report_.slabs == 0) report_.time.begin = slab.timeBegin;
  report_.time.end = slab.timeEnd;
  ++report_.slabs;
  ++number_;
  keepUpperLayer(slab);
  before_ = checked;
  return {};
}

void MeshChecker::State::reportNonManifold(const Checked& checked, const model::Slab& slab) {
  if (checked.nonManifold.empty()) return;
  report_.vertexLinksOk = false;
  // This is the apex of a cone over a surface that is not a single sphere. The cap encloses
  // nothing, so hypervolume and slices stay exact.
  const bool inCap = slab.timeBegin == slab.timeEnd;
  report_.issues.add(
      {inCap ? "cap-vertex-link" : "vertex-link",
       inCap ? Severity::Warning : Severity::Error,
       fmt::format("vertex {} is non-manifold: its link is not a sphere ({} such vertices{})",
                   checked.nonManifold.front(), checked.nonManifold.size(),
                   inCap ? ", inside a cap" : ""),
       number_,
       {}},
      checked.nonManifold.size());
}

void MeshChecker::State::reportFacets(const std::vector<model::Facet>& facets, const char* where,
                                      std::uint64_t slab) {
  std::uint64_t open = 0;
  std::uint64_t inconsistent = 0;
  const model::Facet* firstOpen = nullptr;
  const model::Facet* firstInconsistent = nullptr;
  for (const model::Facet& facet : facets) {
    const bool isOpen = !facet.isClosed();
    ++(isOpen ? open : inconsistent);
    const model::Facet*& first = isOpen ? firstOpen : firstInconsistent;
    if (first == nullptr) first = &facet;
  }
  const auto name = [&](const model::Facet& facet) {
    return fmt::format("facet {}-{}-{} {}, of cell {},", facet.vertices[0], facet.vertices[1],
                       facet.vertices[2], where, facet.cell);
  };
  if (firstOpen != nullptr) {
    report_.closed = false;
    report_.issues.add({"facet-not-shared-by-two",
                        Severity::Error,
                        fmt::format("{} has {} cells, not 2 ({} such facets)", name(*firstOpen),
                                    firstOpen->even + firstOpen->odd, open),
                        slab,
                        {}},
                       open);
  }
  if (firstInconsistent != nullptr) {
    report_.oriented = false;
    report_.issues.add({"facet-orientation",
                        Severity::Error,
                        fmt::format("{} has both its cells on the same side ({} such facets)",
                                    name(*firstInconsistent), inconsistent),
                        slab,
                        {}},
                       inconsistent);
  }
}

/// Checks the layer between the previous slab and `after`; either is absent at an end of the mesh.
void MeshChecker::State::checkSeam(const model::Slab* after, const CheckedPointer& checkedAfter) {
  if (!before_ && options_.goesOnBefore) return;
  const std::uint32_t upper = before_ ? before_->connectivity->upperCount : 0;
  if (after != nullptr && before_) {
    if (upper == after->connectivity->lowerCount) {
      compareLayers(*after);
    } else {
      report_.issues.add({"seam-differs",
                          Severity::Error,
                          fmt::format("the lower layer has {} vertices, the upper layer of the "
                                      "slab before has {}",
                                      after->connectivity->lowerCount, upper),
                          number_,
                          {}});
    }
  }
  if (seam_->before != before_ || seam_->after != checkedAfter || number_ == 0) {
    const std::vector<model::Facet> kNone;
    seam_->before = before_;
    seam_->after = checkedAfter;
    seam_->unmatched = model::unmatchedAtSeam(before_ ? before_->facets.upper : kNone,
                                              checkedAfter ? checkedAfter->facets.lower : kNone);
    const bool joins = !before_ || !checkedAfter || upper == checkedAfter->connectivity->lowerCount;
    seam_->nonManifold.clear();
    if (options_.vertexLinks && joins && (before_ || checkedAfter)) {
      seam_->nonManifold =
          nonManifoldLayerVertices(before_ ? before_->connectivity.get() : nullptr,
                                   checkedAfter ? checkedAfter->connectivity.get() : nullptr);
    }
  }
  // The last layer belongs to the last slab.
  const std::uint64_t number = checkedAfter || number_ == 0 ? number_ : number_ - 1;
  reportFacets(seam_->unmatched, checkedAfter ? "in the lower layer" : "in the last layer", number);
  if (!seam_->nonManifold.empty()) {
    report_.vertexLinksOk = false;
    report_.issues.add({"vertex-link",
                        Severity::Error,
                        fmt::format("vertex {} of the {} layer is non-manifold: its link is not a "
                                    "sphere ({} such vertices)",
                                    seam_->nonManifold.front(), checkedAfter ? "lower" : "last",
                                    seam_->nonManifold.size()),
                        number,
                        {}},
                       seam_->nonManifold.size());
  }
}

void MeshChecker::State::compareLayers(const model::Slab& slab) {
  const bool apart = slab.connectivity->lowerCount == 0 ? slab.timeBegin < report_.time.end
                                                        : slab.timeBegin != report_.time.end;
  if (apart) {
    report_.issues.add({"slab-times",
                        Severity::Error,
                        fmt::format("begins at time {}, the slab before ends at {}", slab.timeBegin,
                                    report_.time.end),
                        number_,
                        {}});
  }
  const auto lower = slab.lowerLayer();
  for (std::size_t i = 0; i < lower.size(); ++i) {
    if (lower[i] != upperLayer_[i]) {
      report_.issues.add(
          {"seam-differs",
           Severity::Error,
           fmt::format(
               "vertex {} of the lower layer is ({}, {}, {}, {}), in the upper layer of the "
               "slab before it is ({}, {}, {}, {})",
               i, lower[i][0], lower[i][1], lower[i][2], lower[i][3], upperLayer_[i][0],
               upperLayer_[i][1], upperLayer_[i][2], upperLayer_[i][3]),
           number_,
           {}});
      break;
    }
  }
  if (lower.empty()) return;
  const std::vector<model::Attribute> attributes =
      vertexRows(slab.attributes, 0, slab.connectivity->lowerCount);
  if (attributes != upperAttributes_) {
    report_.issues.add(
        {"seam-differs",
         Severity::Error,
         "the attributes of the vertices of the lower layer differ from those in the "
         "slab before",
         number_,
         {}});
  }
}

void MeshChecker::State::add(const SlabMeasure& measured, const model::Slab& slab) {
  for (const std::uint32_t index : measured.flat) {
    const model::Cell& cell = slab.connectivity->cells[index];
    ++report_.degenerateCells;
    report_.issues.add({"degenerate-cell",
                        Severity::Warning,
                        fmt::format("cell {} ({}, {}, {}, {}) has no volume", index, cell[0],
                                    cell[1], cell[2], cell[3]),
                        number_,
                        {}});
  }
  part_.boundaryVolume.add(measured.boundaryVolume);
  // The hypervolumes of slabs partly cancel.
  part_.hypervolume.add(measured.hypervolume);
  part_.hypervolumeMagnitude.add(std::abs(measured.hypervolume));
  part_.hasPositive = part_.hasPositive || measured.sign > 0;
  part_.hasNegative = part_.hasNegative || measured.sign < 0;
}

/// Stores what the next slab must repeat.
void MeshChecker::State::keepUpperLayer(const model::Slab& slab) {
  const model::Connectivity& connectivity = *slab.connectivity;
  upperLayer_.assign(slab.upperLayer().begin(), slab.upperLayer().end());
  upperAttributes_ =
      vertexRows(slab.attributes, connectivity.firstUpper(), connectivity.upperCount);
}

Result<void> MeshChecker::State::startAfter(const model::Slab& slab, std::uint64_t number) {
  const auto prepared = prepare(slab);
  const auto& found = static_cast<const Measured&>(*prepared).checked;
  if (!found) return invalid(found.error().message, placeIn({}, fmt::format("slab {}", number)));
  const model::Connectivity& connectivity = *slab.connectivity;
  components_.add((*found)->components, connectivity.lowerCount, connectivity.upperCount);
  report_.time.end = slab.timeEnd;
  keepUpperLayer(slab);
  before_ = *found;
  number_ = number + 1;
  return {};
}

namespace {

/// Whether the hypervolume is positive for certain.
bool enclosesSomething(const PartOfMesh& whole) {
  if (!whole.hasNegative) return whole.hasPositive;
  // The hypervolume of each slab is rounded about once.
  constexpr double kRounding = 8 * std::numeric_limits<double>::epsilon();
  return whole.hypervolume.value() > kRounding * whole.hypervolumeMagnitude.value();
}

void addMeasures(MeshReport& report, const PartOfMesh& part, std::uint64_t components) {
  report.hypervolume = part.hypervolume.value();
  report.boundaryVolume = part.boundaryVolume.value();
  report.components = components;
}

MeshReport concluded(PartOfMesh whole, std::uint64_t components, bool isPart) {
  MeshReport& report = whole.found;
  addMeasures(report, whole, components);
  if (report.tetrahedra == 0) {
    report.issues.add({"no-cells", Severity::Error, "the mesh has no cells", {}, {}});
  } else if (!isPart && report.closed && report.oriented && !enclosesSomething(whole)) {
    report.issues.add({"inside-out",
                       Severity::Error,
                       fmt::format("the enclosed hypervolume is {}: the mesh is inside out or "
                                   "encloses nothing",
                                   report.hypervolume),
                       {},
                       {}});
  }
  return std::move(report);
}

}  // namespace

PartOfMesh MeshChecker::State::finishPart() {
  if (!options_.goesOnAfter) checkSeam(nullptr, nullptr);
  part_.components = components_.span();
  addMeasures(report_, part_, components_.count());
  return std::move(part_);
}

MeshReport MeshChecker::State::finish() {
  if (!options_.goesOnAfter) checkSeam(nullptr, nullptr);
  return concluded(std::move(part_), components_.count(),
                   options_.goesOnBefore || options_.goesOnAfter);
}

MeshChecker::MeshChecker(CheckOptions options) : state_(std::make_unique<State>(options)) {}
MeshChecker::~MeshChecker() = default;

Result<void> MeshChecker::put(const model::Slab& slab) {
  return putPrepared(slab, prepare(slab).get());
}

std::unique_ptr<model::Sink::Prepared> MeshChecker::prepare(const model::Slab& slab) const {
  return state_->prepare(slab);
}

Result<void> MeshChecker::putPrepared(const model::Slab& slab, Prepared* prepared) {
  return state_->putPrepared(slab, prepared);
}

Result<void> MeshChecker::startAfter(const model::Slab& slab, std::uint64_t number) {
  return state_->startAfter(slab, number);
}

MeshReport MeshChecker::finish() { return state_->finish(); }
PartOfMesh MeshChecker::finishPart() { return state_->finishPart(); }

Result<MeshReport> joinedReport(const std::vector<PartOfMesh>& parts) {
  PartOfMesh whole = parts.front();
  MeshReport& sum = whole.found;
  std::vector<ComponentSpan> spans = {whole.components};
  for (std::size_t i = 1; i < parts.size(); ++i) {
    const MeshReport& one = parts[i].found;
    if (one.slabs > 0) sum.time = {sum.slabs == 0 ? one.time.begin : sum.time.begin, one.time.end};
    sum.slabs += one.slabs;
    sum.vertices += one.vertices;
    sum.tetrahedra += one.tetrahedra;
    sum.bounds.add(one.bounds);
    sum.closed = sum.closed && one.closed;
    sum.oriented = sum.oriented && one.oriented;
    sum.degenerateCells += one.degenerateCells;
    if (sum.vertexLinksOk)
      sum.vertexLinksOk = *sum.vertexLinksOk && one.vertexLinksOk.value_or(true);
    sum.issues.add(one.issues);
    whole.hypervolume.add(parts[i].hypervolume);
    whole.hypervolumeMagnitude.add(parts[i].hypervolumeMagnitude);
    whole.boundaryVolume.add(parts[i].boundaryVolume);
    whole.hasPositive = whole.hasPositive || parts[i].hasPositive;
    whole.hasNegative = whole.hasNegative || parts[i].hasNegative;
    spans.push_back(parts[i].components);
  }
  std::uint64_t components = 0;
  if (!countComponents(spans, components)) {
    return invalid("the parts do not follow one another: their components do not fit");
  }
  return concluded(std::move(whole), components, false);
}

Result<MeshReport> checkMesh(const model::Source& source, CheckOptions options,
                             const model::Progress& progress) {
  MeshChecker checker(options);
  if (auto done = model::pump(source, checker, progress); !done) return done.error();
  return checker.finish();
}

}  // namespace t4d::measure
