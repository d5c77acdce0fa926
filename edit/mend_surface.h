#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "model/error.h"
#include "model/slab.h"
#include "model/triangle_mesh.h"

namespace t4d::edit {

/// Options and limits of mendSurface, in length units.
struct MendSurfaceOptions {
  /// Merge vertices no farther apart than this along each axis; 0 merges equal ones.
  double weld = 0;
  /// Fill no hole wider than this: the largest distance between two vertices of its boundary.
  std::optional<double> maxHole = {};
  /// Return no surface with a point farther than this from the input's.
  std::optional<double> maxMove = {};
  /// If nothing else helps, make a new surface from voxels of this size (remesh_surface.h).
  std::optional<double> remesh = {};
  /// Give sheets this thickness: open surfaces that would enclose nothing if their holes were
  /// filled.
  std::optional<double> thicken = {};
};

enum class SurfaceFault : std::uint8_t {
  Doubled,      ///< vertices near each other, merged
  Duplicate,    ///< triangles with the corners of another one, or with a corner twice, dropped
  Stray,        ///< triangles that hang at an edge of a surface, or divide its inside, dropped
  Turned,       ///< triangles that disagreed with their neighbours, turned
  Sheet,        ///< sheets, which got a thickness
  Hole,         ///< holes, filled
  InsideOut,    ///< components that faced inward, turned
  Crossing,     ///< pairs of triangles that met; the outer surface was taken
  NonManifold,  ///< vertices and edges where surfaces touched, taken apart
  Remeshed,     ///< triangles of a new surface in place of the input's
};

struct SurfaceChange {
  SurfaceFault kind = SurfaceFault::Doubled;
  std::uint64_t count = 0;
  std::string text;  ///< what was done, as a sentence without a full stop
};

/// The word for a kind in JSON.
const char* nameOf(SurfaceFault kind);

/// What the input had outside of the mended solid: fins, sheets, parts that were inside out.
struct LostSurface {
  std::uint64_t triangles = 0;  ///< of the input that reach out of the solid
  double distance = 0;          ///< how far they do, in length units
};

struct MendSurfaceReport {
  std::vector<SurfaceChange> changes;
  /// The Hausdorff distance between the surfaces before and after, in length units. It may be too
  /// small by a ten-thousandth of their diagonal.
  double hausdorff = 0;
  /// The volume that the input encloses, what overlaps counted again; nothing if it was open.
  std::optional<double> volumeBefore = {};
  double volumeAfter = 0;
  model::Bounds3 boundsBefore = {};  ///< of triangles, without unused vertices
  model::Bounds3 boundsAfter = {};
  /// What was dropped outside of the result, if it reaches farther out than a thousandth of the
  /// diagonal, the distance of `weld`, and two voxels of `remesh` where that was needed.
  LostSurface lost = {};
  // Properties of the result. Always true if mendSurface succeeds.
  bool closed = false;
  bool manifold = false;
  /// 0; nothing where they are accepted, and in a build without CGAL, which does not look for them.
  std::optional<std::uint64_t> selfIntersections = {};
  std::uint64_t components = 0;
};

/// Changes a surface so that it bounds a solid: closed, manifold, facing outward, without
/// self-intersections and flat triangles, also after equal vertices are merged. In this order:
/// 1. merges vertices; drops triangles that this collapses, and equal triangles: both where solids
///    meet back to back and in sheets with two sides, all but one where one is given again;
/// 2. drops stray parts: where an odd number of triangles, three or more, meet at edges, the
///    smallest part between such edges whose removal leaves no fewer than two at each, unless it is
///    a solid with a hole: it has more than twice the area that closes its rim;
/// 3. turns triangles so that neighbours agree; in each component, those with less area in total.
///    Nothing is turned where each edge is traversed equally often in both directions;
/// 4. gives sheets a thickness, if there is one; fills holes, without new vertices;
/// 5. turns components that enclose a negative volume and are not inside another one;
/// 6. takes the outer surface, the boundary of where the winding number is 1 or more, if triangles
///    cross, overlap, touch or are flat, if edges have more than two triangles, and if components
///    are nested without being cavities;
/// 7. separates parts that touch at vertices and edges: each copy of a vertex moves into its solid,
///    or in another direction if that leaves fewer crossings, by a hundred-thousandth of the
///    diagonal or a tenth of its shortest edge if that is less.
///
/// A surface without such faults is not changed. All decisions use exact predicates, except for
/// winding numbers, which must be close to integers. On failure nothing is changed. Fails if
/// the result would exceed the limits or could not be made; the remedy of the error is the option
/// that helps: Remesh, MaxHole or MaxMove. Attributes are dropped. A build without CGAL does not
/// look for crossings and flat triangles, and fails if there are holes or nested components.
Result<MendSurfaceReport> mendSurface(model::TriangleMesh& mesh,
                                      const MendSurfaceOptions& options = {},
                                      const model::Progress& progress = {});

}  // namespace t4d::edit
