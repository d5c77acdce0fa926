// The functions that need CGAL, in a build without it.
#include "edit/convex_hull.h"
#include "edit/fill_hole.h"
#include "edit/outer_surface.h"
#include "edit/surface_crossings.h"

namespace t4d::edit {
namespace {

Error noCgal() {
  return fail(
      ErrorCode::Unsupported,
      "this build has no CGAL, which filling holes, hulls and taking the outer surface need");
}

}  // namespace

Result<model::TriangleMesh> convexHull(std::span<const model::Point3> /*points*/) {
  return noCgal();
}

bool findsCrossings() { return false; }

Result<SurfaceCrossings> findCrossings(const model::TriangleMesh& /*mesh*/, std::size_t /*most*/) {
  return noCgal();
}

Result<SurfaceCrossings> findCrossingsOf(std::span<const std::uint32_t> /*triangles*/,
                                         const model::TriangleMesh& /*mesh*/) {
  return noCgal();
}

Result<std::optional<mesh4d::StepCrossing>> crossingWithin(const model::TriangleMesh& /*mesh*/,
                                                           const model::Slab& /*step*/) {
  return noCgal();
}

Result<OuterSurface> outerSurface(const model::TriangleMesh& /*mesh*/,
                                  const SurfaceCrossings& /*crossings*/) {
  return noCgal();
}

Result<std::vector<model::Triangle>> fillHole(const model::TriangleMesh& /*mesh*/,
                                              std::span<const std::uint32_t> /*loop*/,
                                              std::span<const std::uint32_t> /*apexes*/) {
  return noCgal();
}

}  // namespace t4d::edit
