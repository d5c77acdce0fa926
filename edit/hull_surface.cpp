#include <utility>
#include <vector>

#include "edit/carried_attributes.h"
#include "edit/convex_hull.h"
#include "edit/mend_steps.h"
#include "t4d/check.h"
#include "t4d/edit.h"

namespace t4d::edit {

Result<MendSurfaceReport> hullSurface(model::TriangleMesh& mesh) {
  if (auto checked = checkElements(mesh); !checked) return checked.error();
  MendSurfaceReport report;
  model::TriangleMesh welded{mesh.vertices, mesh.triangles, {}};
  weldVertices(welded, 0);
  measureBefore(welded, report);
  model::TriangleMesh used = welded;
  dropUnusedVertices(used);
  auto hull = convexHull(used.vertices);
  if (!hull) return hull.error();
  note(report.changes, SurfaceFault::Hull, hull->triangles.size(),
       "took the convex hull: " + numberOf(hull->triangles.size(), "triangle", "triangles"));
  report.hausdorff = measure::surfaceDistance(mesh, *hull).hausdorff();
  report.volumeAfter = signedVolume(*hull);
  report.boundsAfter = boundsOf(*hull);
  report.closed = true;
  report.manifold = true;
  report.selfIntersections = 0;
  report.components = 1;
  hull->attributes = carriedAttributes(mesh, welded.triangles, *hull, {});
  mesh = std::move(*hull);
  return report;
}

}  // namespace t4d::edit
