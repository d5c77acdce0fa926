#include "t4d/verbs/mending.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace t4d::verbs {

using nlohmann::ordered_json;

namespace {

/// An error that says no place is about this one.
Result<edit::MendSurfaceReport> mendedAt(Result<edit::MendSurfaceReport> report,
                                         const Place& where) {
  if (report || !report.error().where.empty()) return report;
  Error error = report.error();
  error.where = where;
  return error;
}

}  // namespace

Result<edit::MendSurfaceReport> mendSolid(model::TriangleMesh& mesh,
                                          const edit::MendSurfaceOptions& options,
                                          const Place& where, Observer& observer) {
  const auto stage = observer.stage("mending");
  return mendedAt(edit::mendSurface(mesh, options, stage->callback()), where);
}

Result<edit::MendSurfaceReport> mendDeformedSolid(model::TriangleMesh& mesh,
                                                  std::unique_ptr<model::VertexKeys>& keys,
                                                  const edit::MendSurfaceOptions& options,
                                                  const Place& where, Observer& observer) {
  const auto stage = observer.stage("mending");
  return mendedAt(edit::mendDeformation(mesh, keys, options), where);
}

void addMended(const edit::MendSurfaceReport& body, const std::string& name,
               std::optional<edit::MendSurfaceReport>& all) {
  const bool first = !all;
  if (first) {
    all = body;
    all->changes.clear();
  } else {
    all->hausdorff = std::max(all->hausdorff, body.hausdorff);
    if (!body.volumeBefore) all->volumeBefore.reset();
    if (all->volumeBefore) *all->volumeBefore += *body.volumeBefore;
    all->volumeAfter += body.volumeAfter;
    all->components += body.components;
  }
  for (edit::SurfaceChange change : body.changes) {
    if (!name.empty()) change.text = fmt::format("body '{}': {}", name, change.text);
    all->changes.push_back(std::move(change));
  }
}

ordered_json mendJson(const edit::MendSurfaceReport& report) {
  ordered_json changes = ordered_json::array();
  for (const edit::SurfaceChange& change : report.changes) {
    changes.push_back(
        {{"kind", edit::nameOf(change.kind)}, {"count", change.count}, {"text", change.text}});
  }
  const ordered_json before = report.volumeBefore ? ordered_json(*report.volumeBefore) : nullptr;
  return {{"changes", changes},
          {"hausdorff", report.hausdorff},
          {"volume_before", before},
          {"volume_after", report.volumeAfter},
          {"closed", report.closed},
          {"manifold", report.manifold},
          {"self_intersections",
           report.selfIntersections ? ordered_json(*report.selfIntersections) : nullptr},
          {"components", report.components}};
}

std::string measuresOf(const edit::MendSurfaceReport& report) {
  const char* unchecked =
      report.selfIntersections ? "" : "; self-intersections not checked (no CGAL in this build)";
  if (report.changes.empty()) return fmt::format("volume {:.12g}{}", report.volumeAfter, unchecked);
  return fmt::format(
      "volume {:.12g}, {}; Hausdorff distance {:.6g}{}", report.volumeAfter,
      report.volumeBefore ? fmt::format("{:.12g} before", *report.volumeBefore) : "open before",
      report.hausdorff, unchecked);
}

std::vector<std::string> noticesOf(const edit::MendSurfaceReport& report) {
  std::vector<std::string> notices;
  for (const edit::SurfaceChange& change : report.changes) notices.push_back(change.text);
  if (!notices.empty()) notices.push_back("mended: " + measuresOf(report));
  return notices;
}

}  // namespace t4d::verbs
