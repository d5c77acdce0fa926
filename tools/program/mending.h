#pragma once

#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "t4d/edit/mend_deformation.h"
#include "t4d/edit/mend_surface.h"

namespace t4d::tools {

/// The limits of mending, as options of a verb.
struct MendingOptions {
  edit::MendSurfaceOptions limits;

  /// Adds `--weld`, `--max-hole`, `--max-move` and `--remesh`.
  void addTo(CLI::App& command);
  /// Adds `--mend` as well, and lets the others need it.
  void addTo(CLI::App& command, bool& mend);
};

/// Mends a mesh read from `path`, with progress.
Result<edit::MendSurfaceReport> mend(model::TriangleMesh& mesh, const MendingOptions& options,
                                     const std::string& path);

/// Mends the surface of a deformation, which no vertex is moved for, likewise.
Result<edit::MendSurfaceReport> mendDeformation(model::TriangleMesh& mesh,
                                                std::unique_ptr<model::VertexKeys>& keys,
                                                const MendingOptions& options,
                                                const std::string& path);

/// Adds the report of the body `name`, "" if there is but one, to that of those before it.
void addMended(const edit::MendSurfaceReport& body, const std::string& name,
               std::optional<edit::MendSurfaceReport>& all);

/// The report as JSON (docs/mend.md).
nlohmann::ordered_json mendJson(const edit::MendSurfaceReport& report);

/// The volumes and how far the surface moved, on one line.
std::string measuresOf(const edit::MendSurfaceReport& report);

/// The report as sentences, for a verb that does something else after mending.
std::vector<std::string> noticesOf(const edit::MendSurfaceReport& report);

}  // namespace t4d::tools
