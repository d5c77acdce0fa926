#include "t4d/conformance/oracle.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "t4d/convert/slice.h"
#include "t4d/measure/surface_genus.h"

namespace t4d::conformance {
namespace {

constexpr const char* kByDefinition = "by definition of a 4D mesh";

/// Counts what a mesh has between its caps.
class SideCounter : public model::Sink {
 public:
  Result<void> put(const model::Slab& slab) override {
    const model::Connectivity& connectivity = *slab.connectivity;
    if (slab.timeBegin == slab.timeEnd) return {};
    // The lower layer was counted as the upper layer of the slab before, unless that is a cap.
    counts_.vertices +=
        connectivity.vertexCount - (counts_.tetrahedra == 0 ? 0 : connectivity.lowerCount);
    counts_.tetrahedra += connectivity.cells.size();
    return {};
  }
  const Counts& counts() const { return counts_; }

 private:
  Counts counts_;
};

/// Hands slabs to both judges in one reading.
class Both : public model::Sink {
 public:
  Both(model::Sink& first, model::Sink& second) : first_(first), second_(second) {}
  Result<void> put(const model::Slab& slab) override {
    return first_.put(slab).and_then([&] { return second_.put(slab); });
  }

 private:
  model::Sink& first_;
  model::Sink& second_;
};

/// What the checker found first of a kind, with its slab.
std::string firstOf(const measure::MeshReport& report, std::initializer_list<const char*> codes) {
  for (const measure::Issue& issue : report.issues.issues) {
    for (const char* code : codes) {
      if (issue.code != code) continue;
      return issue.slab ? fmt::format("slab {}: {}", *issue.slab, issue.message) : issue.message;
    }
  }
  return {};
}

void judgeMesh(const measure::MeshReport& report, const Law& law, std::vector<Check>& checks) {
  const auto lacks = [&](const char* name, std::initializer_list<const char*> codes,
                         const char* reason) {
    const std::string found = firstOf(report, codes);
    checks.push_back(holds(name, true, found.empty(), reason, found));
  };
  lacks("seams", {"seam-differs", "slab-times"},
        "the upper layer of a slab equals the lower layer of the next");
  lacks("closed", {"facet-not-shared-by-two", "no-cells"}, "every facet has exactly two cells");
  lacks("oriented", {"facet-orientation", "inside-out"},
        "on opposite sides, and the mesh faces outward");
  lacks("vertex links", {"vertex-link"}, "every vertex link is a sphere");
  if (law.manifoldCaps) {
    lacks("vertex links inside the caps", {"cap-vertex-link"}, "every vertex link is a sphere");
  }
  checks.push_back(countIs("degenerate cells", 0, report.degenerateCells,
                           "no cell without volume, up to the rounding of its corners",
                           firstOf(report, {"degenerate-cell"})));
  checks.push_back(measureIs("time begin", law.timeBegin, report.time.begin));
  checks.push_back(measureIs("time end", law.timeEnd, report.time.end));
  if (law.bounds) {
    for (int axis = 0; axis < 3; ++axis) {
      const char name = "xyz"[axis];
      const auto face = [&](double value) {
        return Measure{value, law.bounds->tolerance, law.bounds->reason};
      };
      checks.push_back(measureIs(fmt::format("least {}", name), face(law.bounds->box.min[axis]),
                                 report.bounds.min[axis]));
      checks.push_back(measureIs(fmt::format("largest {}", name), face(law.bounds->box.max[axis]),
                                 report.bounds.max[axis]));
    }
  }
  if (law.hypervolume) {
    checks.push_back(measureIs("hypervolume", *law.hypervolume, report.hypervolume));
  }
}

void judgeCounts(const char* what, const Counts& expected, const Counts& actual,
                 const std::string& reason, std::vector<Check>& checks) {
  checks.push_back(
      countIs(fmt::format("vertices{}", what), expected.vertices, actual.vertices, reason));
  checks.push_back(
      countIs(fmt::format("tetrahedra{}", what), expected.tetrahedra, actual.tetrahedra, reason));
}

/// Returns the volume.
std::optional<double> judgeSlice(const model::Source& mesh, const SliceLaw& law,
                                 std::vector<Check>& checks) {
  const auto named = [&](const std::string& what) {
    return fmt::format("slice at {:.6g}: {}", law.time, what);
  };
  const auto slice = convert::sliceAtTime(mesh, law.time);
  if (!slice) {
    checks.push_back(holds(named("exists"), true, false, kByDefinition, slice.error().text()));
    return std::nullopt;
  }
  checks.push_back(holds(named("closed"), true, isClosed(slice->mesh),
                         "a slice of a closed 4D mesh is a closed surface"));
  const double volume = signedVolume(slice->mesh);
  if (law.volume) checks.push_back(measureIs(named("volume"), *law.volume, volume));
  if (law.surface) {
    double farthest = 0;
    for (const model::Point3& vertex : slice->mesh.vertices) {
      farthest = std::max(farthest, std::abs(law.surface->distance(vertex)));
    }
    checks.push_back(measureIs(named("farthest vertex from the true surface"),
                               {0, law.surface->tolerance, law.surface->reason}, farthest));
  }
  if (!law.genera) return volume;
  const std::vector<double> genera = measure::generaOf(slice->mesh);
  const char* reason = "the topology of the solid; V - E + F = 2 - 2 genus";
  checks.push_back(countIs(named("surfaces"), law.genera->size(), genera.size(), reason));
  for (std::size_t i = 0; i < std::min(genera.size(), law.genera->size()); ++i) {
    const std::string which =
        law.genera->size() == 1 ? "genus" : fmt::format("genus of surface {}", i + 1);
    checks.push_back(
        measureIs(named(which), {static_cast<double>((*law.genera)[i]), 0, reason}, genera[i]));
  }
  return volume;
}

}  // namespace

Check holds(std::string name, bool expected, bool actual, std::string reason, std::string found) {
  return {std::move(name),   expected,           actual,          0,
          std::move(reason), expected == actual, std::move(found)};
}

Check countIs(std::string name, std::uint64_t expected, std::uint64_t actual, std::string reason,
              std::string found) {
  return {std::move(name),   expected,           actual,          0,
          std::move(reason), expected == actual, std::move(found)};
}

Check measureIs(std::string name, const Measure& expected, double actual) {
  // Not passed where either is not a number.
  const bool passed = std::abs(actual - expected.value) <= expected.tolerance;
  return {std::move(name), expected.value, actual, expected.tolerance, expected.reason, passed, {}};
}

bool Verdict::passed() const {
  return std::all_of(checks.begin(), checks.end(), [](const Check& check) { return check.passed; });
}

Verdict judge(const model::Source& mesh, const Law& law, const model::Progress& progress) {
  Verdict verdict;
  std::vector<Check>& checks = verdict.checks;
  measure::MeshChecker checker({.vertexLinks = true});
  SideCounter sides;
  Both both(checker, sides);
  const auto read = model::pump(mesh, both, progress);
  checks.push_back(holds("slabs", true, read.has_value(),
                         "indices in range, numbers finite, layers exactly at their times",
                         read ? std::string() : read.error().text()));
  if (!read) return verdict;

  const measure::MeshReport report = checker.finish();
  verdict.hypervolume = report.hypervolume;
  verdict.vertices = report.vertices;
  verdict.tetrahedra = report.tetrahedra;
  judgeMesh(report, law, checks);
  if (law.counts) {
    judgeCounts("", *law.counts, {report.vertices, report.tetrahedra}, law.countsReason, checks);
  }
  if (law.sideCounts) {
    judgeCounts(" between the caps", *law.sideCounts, sides.counts(), law.countsReason, checks);
  }
  for (const SliceLaw& slice : law.slices) {
    verdict.sliceVolumes.push_back(judgeSlice(mesh, slice, checks));
  }
  return verdict;
}

}  // namespace t4d::conformance
