#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "measure/surface_genus.h"
#include "t4d/check.h"
#include "t4d/collide.h"
#include "t4d/conformance.h"
#include "t4d/edit.h"
#include "t4d/envelope.h"
#include "t4d/mesh.h"
#include "t4d/slice.h"

namespace t4d::conformance {
namespace {

constexpr const char* kByDefinition = "by definition of a 4D mesh";

/// Counts the vertices and cells of a mesh between its caps.
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

/// The first issue with one of the codes, with its slab; empty if there is none.
std::string firstOf(const measure::MeshReport& report, std::initializer_list<const char*> codes) {
  for (const measure::Issue& issue : report.issues.issues) {
    for (const char* code : codes) {
      if (issue.code != code) continue;
      return issue.slab ? fmt::format("slab {}: {}", *issue.slab, issue.message) : issue.message;
    }
  }
  return {};
}

void checkMesh(const measure::MeshReport& report, const Expectation& expectation,
               std::vector<Check>& checks) {
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
  if (expectation.manifoldCaps) {
    lacks("vertex links inside the caps", {"cap-vertex-link"}, "every vertex link is a sphere");
  }
  checks.push_back(countIs("degenerate cells", 0, report.degenerateCells,
                           "no cell without volume, up to the rounding of its corners",
                           firstOf(report, {"degenerate-cell"})));
  checks.push_back(measureIs("time begin", expectation.timeBegin, report.time.begin));
  checks.push_back(measureIs("time end", expectation.timeEnd, report.time.end));
  if (expectation.bounds) {
    for (int axis = 0; axis < 3; ++axis) {
      const char name = "xyz"[axis];
      const auto face = [&](double value) {
        return Measure{value, expectation.bounds->tolerance, expectation.bounds->reason};
      };
      checks.push_back(measureIs(fmt::format("least {}", name),
                                 face(expectation.bounds->box.min[axis]), report.bounds.min[axis]));
      checks.push_back(measureIs(fmt::format("largest {}", name),
                                 face(expectation.bounds->box.max[axis]), report.bounds.max[axis]));
    }
  }
  if (expectation.hypervolume) {
    checks.push_back(measureIs("hypervolume", *expectation.hypervolume, report.hypervolume));
  }
}

void checkCounts(const char* what, const Counts& expected, const Counts& actual,
                 const std::string& reason, std::vector<Check>& checks) {
  checks.push_back(
      countIs(fmt::format("vertices{}", what), expected.vertices, actual.vertices, reason));
  checks.push_back(
      countIs(fmt::format("tetrahedra{}", what), expected.tetrahedra, actual.tetrahedra, reason));
}

/// Returns the volume of the slice.
std::optional<double> checkSlice(const model::Source& mesh, const SliceExpectation& expectation,
                                 std::vector<Check>& checks) {
  const auto named = [&](const std::string& what) {
    return fmt::format("slice at {:.6g}: {}", expectation.time, what);
  };
  const auto slice = slice::sliceAtTime(mesh, expectation.time);
  if (!slice) {
    checks.push_back(holds(named("exists"), true, false, kByDefinition, slice.error().text()));
    return std::nullopt;
  }
  checks.push_back(holds(named("closed"), true, isClosed(slice->mesh),
                         "a slice of a closed 4D mesh is a closed surface"));
  const double volume = signedVolume(slice->mesh);
  if (expectation.volume) checks.push_back(measureIs(named("volume"), *expectation.volume, volume));
  if (expectation.surface) {
    double farthest = 0;
    for (const model::Point3& vertex : slice->mesh.vertices) {
      farthest = std::max(farthest, std::abs(expectation.surface->distance(vertex)));
    }
    checks.push_back(measureIs(named("farthest vertex from the true surface"),
                               {0, expectation.surface->tolerance, expectation.surface->reason},
                               farthest));
  }
  if (!expectation.genera) return volume;
  const std::vector<double> genera = measure::generaOf(slice->mesh);
  const char* reason = "the topology of the solid; V - E + F = 2 - 2 genus";
  checks.push_back(countIs(named("surfaces"), expectation.genera->size(), genera.size(), reason));
  for (std::size_t i = 0; i < std::min(genera.size(), expectation.genera->size()); ++i) {
    const std::string which =
        expectation.genera->size() == 1 ? "genus" : fmt::format("genus of surface {}", i + 1);
    checks.push_back(measureIs(
        named(which), {static_cast<double>((*expectation.genera)[i]), 0, reason}, genera[i]));
  }
  return volume;
}

void checkVisits(const model::Source& mesh, const Measure& expectation,
                 std::vector<Check>& checks) {
  const std::string name = "visits volume";
  const auto silhouette = measure::silhouetteOf(mesh);
  checks.push_back(silhouette ? measureIs(name, expectation, silhouette->visitsVolume)
                              : holds(name, true, false, "the boundary of all exits is closed",
                                      silhouette.error().text()));
}

void checkNormalSpeed(const model::Source& mesh, const Measure& expectation,
                      std::vector<Check>& checks) {
  const std::string name = "mean normal speed";
  const model::Body body{{}, &mesh};
  const auto speed = measure::meanNormalSpeed({&body, 1});
  checks.push_back(speed ? measureIs(name, expectation, *speed)
                         : holds(name, true, false, kByDefinition, speed.error().text()));
}

constexpr measure::CollideOptions kContactsOnly{.clearance = false, .overlapVolumes = false};

/// Moves the mesh out of the way of the obstacle.
void checkGivesWay(const model::Source& mesh, const model::Source& obstacle,
                   std::vector<Check>& checks) {
  const model::Body body{{}, &mesh};
  const model::Body other{{}, &obstacle};
  const auto resolved = edit::resolve({&other, 1}, body, {});
  checks.push_back(holds("gives way to the obstacle", true, resolved.has_value(),
                         "only a part of the solid is in its way",
                         resolved ? std::string() : resolved.error().text()));
  if (!resolved) return;
  const auto collision = measure::collide(*resolved->source, obstacle, kContactsOnly);
  checks.push_back(holds("clear of the obstacle then", true, collision && !collision->contact(),
                         "by the exact test of cells in space-time",
                         collision ? std::string() : collision.error().text()));
  measure::MeshChecker checker;
  const auto read = model::pump(*resolved->source, checker);
  checks.push_back(holds("closed and oriented then", true,
                         read && checker.finish().issues.issues.empty(), kByDefinition,
                         read ? std::string() : read.error().text()));
}

void checkContact(const model::Source& mesh, const ContactExpectation& expectation,
                  std::vector<Check>& checks) {
  const std::string name = "first contact with the obstacle";
  const auto collision = measure::collide(mesh, *expectation.obstacle, kContactsOnly);
  if (collision && collision->contact()) {
    checks.push_back(measureIs(name, expectation.time, collision->intervals.front().begin));
  } else {
    checks.push_back(holds(name, true, false, "the moving solid touches it",
                           collision ? "they never touch" : collision.error().text()));
  }
  if (expectation.canGiveWay) checkGivesWay(mesh, *expectation.obstacle, checks);
}

void checkTracks(const model::Source& mesh, const TracksExpectation& expectation,
                 std::vector<Check>& checks) {
  const auto tracks = measure::tracksOf(mesh, {.times = {}, .layers = false});
  if (!tracks) {
    checks.push_back(holds("tracks", true, false, kByDefinition, tracks.error().text()));
    return;
  }
  const char* reason = "the topology of the solid over time";
  checks.push_back(countIs("tracks", expectation.tracks, tracks->tracks.size(), reason));
  std::vector<measure::TrackEvent> events = tracks->events;
  if (!expectation.events.empty()) {
    std::erase_if(events, [&](const measure::TrackEvent& event) {
      return std::ranges::find(expectation.events, event.kind, &EventExpectation::kind) ==
             expectation.events.end();
    });
  }
  checks.push_back(countIs("events", expectation.events.size(), events.size(), reason));
  for (std::size_t i = 0; i < std::min(events.size(), expectation.events.size()); ++i) {
    const EventExpectation& expected = expectation.events[i];
    const std::string name = fmt::format("event {}", i + 1);
    checks.push_back(holds(name + ": kind", true, events[i].kind == expected.kind, reason));
    checks.push_back(measureIs(name + ": time", expected.time, events[i].time));
  }
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
  // Fails if either is NaN.
  const bool passed = std::abs(actual - expected.value) <= expected.tolerance;
  return {std::move(name), expected.value, actual, expected.tolerance, expected.reason, passed, {}};
}

bool MeshResult::passed() const {
  return std::all_of(checks.begin(), checks.end(), [](const Check& check) { return check.passed; });
}

MeshResult verify(const model::Source& mesh, const Expectation& expectation,
                  const model::Progress& progress) {
  MeshResult result;
  std::vector<Check>& checks = result.checks;
  measure::MeshChecker checker({.vertexLinks = true});
  SideCounter sides;
  model::Tee both({&checker, &sides});
  const auto read = model::pump(mesh, both, progress);
  checks.push_back(holds("slabs", true, read.has_value(),
                         "indices in range, numbers finite, layers exactly at their times",
                         read ? std::string() : read.error().text()));
  if (!read) return result;

  const measure::MeshReport report = checker.finish();
  result.hypervolume = report.hypervolume;
  result.vertices = report.vertices;
  result.tetrahedra = report.tetrahedra;
  checkMesh(report, expectation, checks);
  if (expectation.counts) {
    checkCounts("", *expectation.counts, {report.vertices, report.tetrahedra},
                expectation.countsReason, checks);
  }
  if (expectation.sideCounts) {
    checkCounts(" between the caps", *expectation.sideCounts, sides.counts(),
                expectation.countsReason, checks);
  }
  for (const SliceExpectation& slice : expectation.slices) {
    result.sliceVolumes.push_back(checkSlice(mesh, slice, checks));
  }
  if (expectation.visitsVolume) checkVisits(mesh, *expectation.visitsVolume, checks);
  if (expectation.meanNormalSpeed) checkNormalSpeed(mesh, *expectation.meanNormalSpeed, checks);
  if (expectation.contact) checkContact(mesh, *expectation.contact, checks);
  if (expectation.tracks) checkTracks(mesh, *expectation.tracks, checks);
  return result;
}

}  // namespace t4d::conformance
