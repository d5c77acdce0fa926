#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "edit/mend_steps.h"
#include "edit/outer_surface.h"
#include "edit/surface_crossings.h"

namespace t4d::edit {
namespace {

using model::Triangle;
using model::TriangleMesh;

/// The search for crossings ends here; cutting more would take minutes.
constexpr std::size_t kMostCrossings = 200'000;
/// Rounding the places of cuts can make new crossings, of the size of the rounding.
constexpr int kMostCuts = 8;

}  // namespace

Result<void> takeOuterSurface(TriangleMesh& mesh, bool always, VertexLineage& lineage,
                              Changes& changes) {
  if (!findsCrossings() && !always) return {};
  const model::Bounds3 bounds = boundsOf(mesh);
  const double size = std::max(bounds.max.cwiseAbs().maxCoeff(), bounds.min.cwiseAbs().maxCoeff());
  std::size_t pairs = 0;
  std::size_t flat = 0;
  std::uint64_t dropped = 0;
  for (int round = 0;; ++round) {
    const auto crossings = findCrossings(mesh, kMostCrossings);
    if (!crossings) return crossings.error();
    if (round == 0) {
      pairs = crossings->pairs.size();
      flat = crossings->flat.size();
    }
    if (crossings->none() && !(always && round == 0)) break;
    if (!crossings->complete || round == kMostCuts) {
      return fail(ErrorCode::Unsupported,
                  crossings->complete
                      ? "the outer surface still crosses itself when its vertices are rounded"
                      : fmt::format("more than {} pairs of triangles cross", kMostCrossings),
                  {}, Remedy::Remesh);
    }
    auto outer = outerSurface(mesh, *crossings);
    if (!outer) return outer.error();
    if (outer->mesh.triangles.empty()) {
      return fail(ErrorCode::Unsupported, "the surface encloses nothing", {}, Remedy::Remesh);
    }
    if (round == 0) dropped = outer->dropped;
    if (crossings->none() && dropped == 0) break;  // it is the outer one as it is
    mesh = std::move(outer->mesh);
    lineage.extend(mesh.vertices.size());
    // First the rounding alone; then vertices that are as near as rounding may move them, more each
    // time.
    const double near = round == 0 ? 0 : std::ldexp(size, 2 * round - 52);
    weldVertices(mesh, near);
    std::erase_if(mesh.triangles, hasTwice);
    lineage.select(dropUnusedVertices(mesh));
  }
  if (pairs > 0) {
    note(changes, SurfaceFault::Crossing, pairs,
         fmt::format("took the outer surface where {} met: {} within it dropped",
                     numberOf(pairs, "pair of triangles", "pairs of triangles"),
                     numberOf(dropped, "piece", "pieces")));
  } else {
    note(changes, SurfaceFault::Crossing, dropped,
         fmt::format("dropped {} inside the solid", numberOf(dropped, "triangle", "triangles")));
  }
  note(changes, SurfaceFault::Duplicate, flat,
       fmt::format("dropped {} without area", numberOf(flat, "triangle", "triangles")));
  return {};
}

}  // namespace t4d::edit
