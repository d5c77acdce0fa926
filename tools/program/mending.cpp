#include "tools/program/mending.h"

#include <algorithm>

#include <fmt/format.h>

#include "tools/program/option_checks.h"
#include "tools/program/progress_bar.h"

namespace t4d::tools {

using nlohmann::ordered_json;

namespace {

/// An error that says no place is about this file.
Result<edit::MendSurfaceReport> placed(Result<edit::MendSurfaceReport> report,
                                       const std::string& path) {
  if (report || !report.error().where.empty()) return report;
  Error error = report.error();
  error.where = path;
  return error;
}

}  // namespace

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
  for (const char* name : {"--weld", "--max-hole", "--max-move", "--remesh"}) {
    command.get_option(name)->needs(flag);
  }
}

Result<edit::MendSurfaceReport> mend(model::TriangleMesh& mesh, const MendingOptions& options,
                                     const std::string& path) {
  ProgressBar bar("mending");
  return placed(edit::mendSurface(mesh, options.limits, bar.callback()), path);
}

Result<edit::MendSurfaceReport> mendDeformation(model::TriangleMesh& mesh,
                                                std::unique_ptr<model::VertexKeys>& keys,
                                                const MendingOptions& options,
                                                const std::string& path) {
  const ProgressBar bar("mending");
  return placed(edit::mendDeformation(mesh, keys, options.limits), path);
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

}  // namespace t4d::tools
