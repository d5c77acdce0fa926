#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "edit/vertex_lineage.h"
#include "model/surface_edges.h"
#include "model/unit_scale.h"
#include "t4d/edit.h"
#include "t4d/error.h"
#include "t4d/surface.h"

/// The steps of mendSurface, in order. Each adds its changes to the report.
namespace t4d::edit {

using Changes = std::vector<SurfaceChange>;

inline void note(Changes& changes, SurfaceFault kind, std::uint64_t count, std::string text) {
  if (count > 0) changes.push_back({kind, count, std::move(text)});
}

/// "1 hole", "2 holes".
std::string numberOf(std::uint64_t count, const char* one, const char* many);

double areaOf(const model::TriangleMesh& mesh, std::uint32_t triangle);

inline void reverse(model::Triangle& triangle) { std::swap(triangle[1], triangle[2]); }

inline bool hasTwice(const model::Triangle& triangle) {
  return triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0];
}

/// Fails for a mesh without triangles, indices out of range and coordinates that are not finite.
Result<void> checkElements(const model::TriangleMesh& mesh);

/// Measures the input, with merged vertices and otherwise as it is given.
void measureBefore(const model::TriangleMesh& welded, MendSurfaceReport& report);

/// Measures the result, whose changes and Hausdorff distance are known.
void measureAfter(const model::TriangleMesh& welded, const model::TriangleMesh& mended,
                  const MendSurfaceOptions& options, MendSurfaceReport& report);

// weld_surface.cpp

/// Merges vertices within `tolerance` of each other along each axis, and chains of such vertices,
/// into the first of them. Merged vertices remain, without triangles. Returns their number.
std::size_t weldVertices(model::TriangleMesh& mesh, double tolerance);

/// Drops vertices without triangles. Returns the old numbers of the remaining vertices, in order.
std::vector<std::uint32_t> dropUnusedVertices(model::TriangleMesh& mesh);

/// Calls weldVertices, and adds it to the changes.
void weld(model::TriangleMesh& mesh, double tolerance, Changes& changes);

// drop_duplicates.cpp

/// Drops triangles with a corner twice. Of triangles with the same corners, keeps as many as make
/// the surface traverse the edges around them equally often in both directions: none where solids
/// meet back to back and in sheets with two sides, one where a triangle is given again, several
/// where solids overlap and share a face. Keeps the first where no number does that.
/// Fails if no triangle is left.
Result<void> dropDuplicates(model::TriangleMesh& mesh, Changes& changes);

// drop_stray.cpp

/// What closes its own rim has no more than so many times the area that does. A solid with a hole
/// has more.
inline constexpr double kOfRim = 2;

/// The area that closes these edges, by their numbers: fans about the middle of each set of
/// connected ones.
double areaWithin(const model::TriangleMesh& mesh, const model::SurfaceEdges& edges,
                  const std::vector<std::uint32_t>& rim);

/// Drops fins, and walls that divide the inside.
void dropStray(model::TriangleMesh& mesh, Changes& changes);

// orient_surface.cpp

/// Turns triangles until those that are `mates` (model::matesOf) agree: in each connected part
/// those with less area. Returns how many, or nothing if there is no way.
std::optional<std::size_t> turnToAgree(model::TriangleMesh& mesh,
                                       const std::vector<std::uint32_t>& mates);

/// Turns triangles so that neighbours agree. A connected part that traverses each edge of several
/// triangles equally often in both directions is not changed. Elsewhere orientations spread across
/// edges of two triangles alone; at the others, parts between such edges are turned as a whole if
/// that balances more edges. Fails if a part has only one side.
Result<void> orient(model::TriangleMesh& mesh, Changes& changes);

/// Triangles of a closed mesh that are closed by themselves: connected across edges of two
/// triangles, and at edges of more with the parts that are open there.
struct Component {
  std::vector<std::uint32_t> triangles;
  double volume = 0;
};
std::vector<Component> componentsOf(const model::TriangleMesh& mesh);

/// Turns components that enclose a negative volume and are not inside another one. Returns true if
/// the outer surface must be taken even if no triangles cross: the components are nested in any
/// other way than solids with cavities, or edges have more than two triangles, between which
/// solids may overlap.
bool faceOutward(model::TriangleMesh& mesh, Changes& changes);

// close_holes.cpp

/// Fills holes. The surface is in the unit of `scale`. Fails if a hole is too wide.
Result<void> fillHoles(model::TriangleMesh& mesh, const MendSurfaceOptions& options,
                       const model::UnitScale& scale, Changes& changes);

// take_outer_surface.cpp

/// Takes the outer surface if triangles cross, or in any case if `always`. The result is closed,
/// but may touch itself. A build without CGAL does not look for crossings. `lineage` is that of the
/// vertices of `mesh`.
Result<void> takeOuterSurface(model::TriangleMesh& mesh, bool always, VertexLineage& lineage,
                              Changes& changes);

// take_apart.cpp

/// Whether the mesh bounds a solid when equal vertices are merged, as in a file. A build without
/// CGAL ignores crossings.
Result<bool> isSound(const model::TriangleMesh& mesh);

inline model::Point3 middleOf(std::span<const model::Point3> places, const VertexOrigin& origin) {
  if (origin[0] == origin[1]) return places[origin[0]];
  return 0.5 * places[origin[0]] + 0.5 * places[origin[1]];
}

/// A surface whose parts share neither edges nor vertices where they touch.
struct SplitSurface {
  model::TriangleMesh mesh = {};
  std::vector<VertexOrigin> origins = {};  ///< of its vertices, by those before
  std::vector<std::uint32_t> copies = {};  ///< all vertices that are at the place of another one
  std::size_t vertices = 0;                ///< that were divided, also those in the middle of edges
  std::size_t edges = 0;
};

/// Gives parts that touch vertices of their own, at the same places, and those that touch along an
/// edge one in the middle of it.
SplitSurface splitWhereTouching(const model::TriangleMesh& mesh);
void noteSplit(const SplitSurface& split, Changes& changes);

/// Separates parts that touch each other. `lineage` is that of the vertices of `mesh`.
Result<void> takeApart(model::TriangleMesh& mesh, VertexLineage& lineage, Changes& changes);

// lost_surface.cpp

/// The triangles of `before` that have points outside of the solid `after`, farther than
/// `tolerance` from its surface. Triangles within the solid separate nothing, so nothing is lost
/// with them. Where it is not proved that a triangle has no such points, they are looked for at its
/// corners and the middles of 64 pieces.
LostSurface lostSurface(const model::TriangleMesh& before, const model::TriangleMesh& after,
                        double tolerance);

}  // namespace t4d::edit
