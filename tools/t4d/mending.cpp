#include "tools/t4d/mending.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "edit/surface_crossings.h"
#include "tools/t4d/members.h"
#include "tools/t4d/option_checks.h"

namespace t4d::tools {
namespace {

/// An error that says no place is about this one.
Result<edit::MendSurfaceReport> mendedAt(Result<edit::MendSurfaceReport> report,
                                         const Place& where) {
  if (report || !report.error().where.empty()) return report;
  Error error = report.error();
  error.where = where;
  return error;
}

std::string ofBody(const std::string& name) {
  return name.empty() ? "" : fmt::format("body '{}': ", name);
}

/// Whether two volumes look the same in a message.
bool sameInText(const std::optional<double>& a, double b) {
  return a && fmt::format("{:.12g}", *a) == fmt::format("{:.12g}", b);
}

std::string extentOf(const model::Bounds3& bounds) {
  if (bounds.empty()) return {};
  const model::Point3 size = bounds.max - bounds.min;
  return fmt::format("{:.6g} x {:.6g} x {:.6g}", size.x(), size.y(), size.z());
}

void addMendMeasures(Members& members, const edit::MendSurfaceReport& report) {
  members(
      "hausdorff", report.hausdorff,
      "Hausdorff distance between the surfaces before and after, in length units. It may be too "
      "small by a ten-thousandth of their diagonal.")
      .atLeast(0);
  members("volume_before", report.volumeBefore,
          "Volume that the given surface enclosed; null if it was open.");
  members("volume_after", report.volumeAfter, "Volume that the mended surface encloses.");
  members("lost_triangles", report.lost.triangles,
          "Given triangles with points outside of the mended solid, which were dropped. Above 0, "
          "this is a loss.");
  members("lost_distance", report.lost.distance,
          "Distance that these reach out of the mended solid, in length units.")
      .atLeast(0);
}

void describeBounds(Members& members, const model::Bounds3& bounds) {
  members("min", bounds.min, "Smallest coordinates, in length units.");
  members("max", bounds.max, "Largest coordinates, in length units.");
}

}  // namespace

Result<edit::MendSurfaceReport> mendSolid(model::TriangleMesh& mesh,
                                          const edit::MendSurfaceOptions& options,
                                          const Place& where, Observer& observer) {
  const auto stage = observer.stage("mending");
  return mendedAt(edit::mendSurface(mesh, options, stage->callback()), where);
}

Result<edit::MendSurfaceReport> mendDeformedSolid(model::TriangleMesh& mesh, edit::Runs& runs,
                                                  const edit::MendSurfaceOptions& options,
                                                  edit::Crossings crossings, const Place& where) {
  return mendedAt(edit::mendDeformation(mesh, runs, options, crossings), where);
}

Result<edit::MendSurfaceReport> mendOrHull(model::TriangleMesh& mesh,
                                           const edit::MendSurfaceOptions& options, Hull hull,
                                           const Place& where, Observer& observer) {
  if (hull == Hull::Always) return mendedAt(edit::hullSurface(mesh), where);
  model::TriangleMesh mendable = mesh;
  auto mended = mendSolid(mendable, options, where, observer);
  const bool whole = mended && mended->lost.triangles == 0;
  if (!whole && hull == Hull::Fallback) {
    auto taken = mendedAt(edit::hullSurface(mesh), where);
    if (taken || !mended) return taken;
  }
  if (mended) mesh = std::move(mendable);
  return mended;
}

edit::MendSurfaceReport totalOf(const std::vector<MendedBody>& bodies) {
  edit::MendSurfaceReport total = bodies.front().report;
  total.changes.clear();
  total.boundsBefore = total.boundsAfter = {};
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const auto& [name, body] = bodies[i];
    for (edit::SurfaceChange change : body.changes) {
      change.text = ofBody(name) + change.text;
      total.changes.push_back(std::move(change));
    }
    if (i == 0) continue;
    total.hausdorff = std::max(total.hausdorff, body.hausdorff);
    if (!body.volumeBefore) total.volumeBefore.reset();
    if (total.volumeBefore) *total.volumeBefore += *body.volumeBefore;
    total.volumeAfter += body.volumeAfter;
    total.lost.triangles += body.lost.triangles;
    total.lost.distance = std::max(total.lost.distance, body.lost.distance);
    total.components += body.components;
  }
  return total;
}

void addMending(Members& members, const std::vector<MendedBody>& bodies) {
  const edit::MendSurfaceReport total =
      bodies.empty() ? edit::MendSurfaceReport() : totalOf(bodies);
  members("changes", total.changes, "The changes, in order.",
          [](Members& own, const edit::SurfaceChange& change) {
            own("kind", edit::nameOf(change.kind), "The fault.")
                .oneOf({"doubled", "duplicate", "stray", "turned", "sheet", "hole", "inside-out",
                        "crossing", "non-manifold", "remeshed", "hull"});
            own("count", change.count,
                "Number of vertices, triangles, holes, components or pairs of triangles with this "
                "fault.")
                .atLeast(1);
            own("text", change.text, "The change as a sentence.");
          });
  addMendMeasures(members, total);
  members("closed", total.closed,
          "Whether every edge has two triangles, in opposite directions: true.");
  members("manifold", total.manifold, "Whether every vertex has one fan of triangles: true.");
  members("self_intersections", total.selfIntersections,
          "Pairs of triangles that cross, overlap or touch: 0; null where they are accepted (sweep "
          "--mend with --caps cone, --bodies component or --union), and in a build without CGAL, "
          "which does not look for them.");
  members("components", total.components,
          "Connected parts of the mended surface, including cavities.")
      .atLeast(1);
  members("bodies", bodies, "What was done to each body, in numbers.",
          [](Members& own, const MendedBody& body) {
            own("name", body.name, "Name of the body; empty for one body without a name.");
            addMendMeasures(own, body.report);
            own("bounds_before", body.report.boundsBefore, "Bounding box of the given triangles.",
                describeBounds);
            own("bounds_after", body.report.boundsAfter, "Bounding box of the mended surface.",
                describeBounds);
            own("components", body.report.components,
                "Connected parts of this body, including cavities.")
                .atLeast(1);
          });
}

bool isReshaped(const edit::MendSurfaceReport& report) {
  return report.hausdorff > 0 || report.lost.triangles > 0 ||
         (!report.changes.empty() && !sameInText(report.volumeBefore, report.volumeAfter));
}

bool isHull(const edit::MendSurfaceReport& report) {
  return std::ranges::any_of(report.changes, [](const edit::SurfaceChange& change) {
    return change.kind == edit::SurfaceFault::Hull;
  });
}

std::vector<std::vector<std::string>> rowsOf(const std::vector<MendedBody>& bodies) {
  std::vector<std::vector<std::string>> rows = {
      {"body", "is", "volume", "before", "distance", "extent before", "after"}};
  for (const auto& [name, report] : bodies) {
    std::vector<std::string> row = {name, "as it was", fmt::format("{:.6g}", report.volumeAfter)};
    if (isReshaped(report)) {
      row[1] = isHull(report) ? "its hull" : "mended";
      row.push_back(report.volumeBefore ? fmt::format("{:.6g}", *report.volumeBefore) : "open");
      row.push_back(fmt::format("{:.3g}", report.hausdorff));
      const std::string before = extentOf(report.boundsBefore);
      const std::string after = extentOf(report.boundsAfter);
      if (before != after) row.insert(row.end(), {before, after});
    }
    row.resize(rows.front().size());
    rows.push_back(std::move(row));
  }
  return rows;
}

std::string measuresOf(const edit::MendSurfaceReport& report) {
  const char* unchecked = report.selfIntersections || edit::findsCrossings()
                              ? ""
                              : "; self-intersections not checked (no CGAL in this build)";
  if (report.changes.empty()) return fmt::format("volume {:.12g}{}", report.volumeAfter, unchecked);
  const std::string after = extentOf(report.boundsAfter);
  const std::string before = extentOf(report.boundsBefore);
  return fmt::format(
      "volume {:.12g}, {}{}; Hausdorff distance {:.6g}{}", report.volumeAfter,
      report.volumeBefore ? fmt::format("{:.12g} before", *report.volumeBefore) : "open before",
      after == before ? "" : fmt::format("; extent {}, {} before", after, before), report.hausdorff,
      unchecked);
}

std::vector<std::string> noticesOf(const std::vector<MendedBody>& bodies) {
  std::vector<std::string> notices;
  for (const auto& [name, report] : bodies) {
    for (const edit::SurfaceChange& change : report.changes) {
      notices.push_back(ofBody(name) + change.text);
    }
    if (report.changes.empty()) continue;
    notices.push_back(fmt::format("{}mended: {}", ofBody(name), measuresOf(report)));
  }
  return notices;
}

std::vector<std::string> lossesOf(const std::vector<MendedBody>& bodies) {
  std::vector<std::string> losses;
  for (const auto& [name, report] : bodies) {
    if (report.lost.triangles == 0) continue;
    losses.push_back(fmt::format(
        "{}mending dropped what {} outside of the solid, up to {:.6g} away from it", ofBody(name),
        report.lost.triangles == 1 ? "1 triangle has"
                                   : fmt::format("{} triangles have", report.lost.triangles),
        report.lost.distance));
  }
  return losses;
}

formats::MendedInfo mendedInfoOf(const edit::MendSurfaceReport& report) {
  return {report.volumeBefore,   report.volumeAfter,   report.hausdorff,
          report.lost.triangles, report.lost.distance, isHull(report)};
}

void MendingOptions::addTo(CLI::App& command) {
  command
      .add_option("--weld", limits.weld,
                  "Merge vertices within this distance per axis (default: only equal ones)")
      ->type_name("DISTANCE")
      ->check(numberAboveZero());
  command
      .add_option("--max-hole", limits.maxHole,
                  "Maximum width of holes to fill (default: fill all)")
      ->type_name("WIDTH")
      ->check(numberAboveZero());
  command
      .add_option(
          "--thicken", limits.thicken,
          "Give sheets this thickness: open parts that enclose nothing when they are closed")
      ->type_name("DISTANCE")
      ->check(numberAboveZero());
  command
      .add_option("--max-move", limits.maxMove,
                  "Fail if the result is farther than this from the input surface")
      ->type_name("DISTANCE")
      ->check(numberAboveZero());
  command
      .add_option("--remesh", limits.remesh,
                  "Remesh with voxels of this size if nothing else helps")
      ->type_name("SIZE")
      ->check(numberAboveZero());
}

void MendingOptions::addTo(CLI::App& command, bool& mend) {
  auto* flag = command.add_flag("--mend", mend, "Mend the solid first (see t4d mend)");
  addTo(command);
  for (const char* name : {"--weld", "--max-hole", "--thicken", "--max-move", "--remesh"}) {
    command.get_option(name)->needs(flag);
  }
}

std::optional<edit::MendSurfaceOptions> MendingOptions::given(bool mend) const {
  return mend ? std::optional(limits) : std::nullopt;
}

}  // namespace t4d::tools
