#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "edit/mend_deformation.h"
#include "formats/t4d/body_details.h"
#include "t4d/edit.h"
#include "tools/t4d/observer.h"

namespace t4d::tools {
class Members;

/// A body, and what mending did to it.
struct MendedBody {
  std::string name;  ///< "" if there is but one
  edit::MendSurfaceReport report;
};

/// The cases in which a solid becomes its convex hull (edit::hullSurface), as planners of robots
/// take links.
enum class Hull : std::uint8_t {
  Never,     ///< what cannot be mended is an error, and what mending drops is a loss
  Fallback,  ///< where it cannot be mended, or where mending would drop some of it
  Always,
};

/// Mends a mesh (edit::mendSurface); `where` is the place of errors that have none.
Result<edit::MendSurfaceReport> mendSolid(model::TriangleMesh& mesh,
                                          const edit::MendSurfaceOptions& options,
                                          const Place& where, Observer& observer);

/// Mends a surface that is deformed (edit::mendDeformation); `where` is the place of errors that
/// have none.
Result<edit::MendSurfaceReport> mendDeformedSolid(model::TriangleMesh& mesh, edit::Runs& runs,
                                                  const edit::MendSurfaceOptions& options,
                                                  edit::Crossings crossings, const Place& where);

/// Mends a mesh, or takes its hull. If that has no volume, the error is that of mending.
Result<edit::MendSurfaceReport> mendOrHull(model::TriangleMesh& mesh,
                                           const edit::MendSurfaceOptions& options, Hull hull,
                                           const Place& where, Observer& observer);

/// All bodies together, at least one: changes with the name of their body, sums of volumes and
/// counts, and the largest distances. Without bounds, since bodies may have frames of their own.
edit::MendSurfaceReport totalOf(const std::vector<MendedBody>& bodies);

/// Adds what mending did, of all bodies and of each, as `t4d mend` reports it.
void addMending(Members& members, const std::vector<MendedBody>& bodies);

/// Whether the shape is another one than that of the input: not if vertices were merged or the
/// surface was turned, at the same volume.
bool isReshaped(const edit::MendSurfaceReport& report);

bool isHull(const edit::MendSurfaceReport& report);

/// A row for each body: what became of it, and its measures. The first one has the names of the
/// columns.
std::vector<std::vector<std::string>> rowsOf(const std::vector<MendedBody>& bodies);

/// The volumes, the extents and how far the surface moved, on one line.
std::string measuresOf(const edit::MendSurfaceReport& report);

/// The changes as sentences, and those of each body in numbers, for a verb that does something else
/// after mending.
std::vector<std::string> noticesOf(const std::vector<MendedBody>& bodies);

/// Parts that were dropped outside of the mended solids, a sentence for each body.
std::vector<std::string> lossesOf(const std::vector<MendedBody>& bodies);

/// The data about a mended body that its .t4d file states.
formats::MendedInfo mendedInfoOf(const edit::MendSurfaceReport& report);

/// The limits of mending, as options of a verb.
struct MendingOptions {
  edit::MendSurfaceOptions limits;

  /// Adds `--weld`, `--max-hole`, `--thicken`, `--max-move` and `--remesh`.
  void addTo(CLI::App& command);
  /// Adds `--mend` as well, and lets the others need it.
  void addTo(CLI::App& command, bool& mend);
  /// The limits if `mend` is given.
  std::optional<edit::MendSurfaceOptions> given(bool mend) const;
};

}  // namespace t4d::tools
