#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "t4d/edit/mend_deformation.h"
#include "t4d/edit/mend_surface.h"
#include "t4d/verbs/observer.h"

namespace t4d::verbs {

/// Mends a mesh (edit::mendSurface); `where` is the place of errors that have none.
Result<edit::MendSurfaceReport> mendSolid(model::TriangleMesh& mesh,
                                          const edit::MendSurfaceOptions& options,
                                          const Place& where, Observer& observer);

/// Mends a surface that is deformed (edit::mendDeformation); `where` is the place of errors that
/// have none.
Result<edit::MendSurfaceReport> mendDeformedSolid(model::TriangleMesh& mesh,
                                                  std::unique_ptr<model::VertexKeys>& keys,
                                                  const edit::MendSurfaceOptions& options,
                                                  const Place& where, Observer& observer);

/// Adds the report of the body `name`, "" if there is but one, to that of those before it.
void addMended(const edit::MendSurfaceReport& body, const std::string& name,
               std::optional<edit::MendSurfaceReport>& all);

/// The report as JSON (docs/mend.md).
nlohmann::ordered_json mendJson(const edit::MendSurfaceReport& report);

/// The volumes and how far the surface moved, on one line.
std::string measuresOf(const edit::MendSurfaceReport& report);

/// The report as sentences, for a verb that does something else after mending.
std::vector<std::string> noticesOf(const edit::MendSurfaceReport& report);

}  // namespace t4d::verbs
