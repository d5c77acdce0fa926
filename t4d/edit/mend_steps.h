#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "t4d/edit/mend_surface.h"
#include "t4d/model/error.h"
#include "t4d/model/triangle_mesh.h"
#include "t4d/model/unit_scale.h"

/// The steps of mendSurface, in their order. Each notes what it changed.
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

// weld_surface.cpp

/// Merges vertices within `tolerance` of each other along each axis, through chains of such pairs,
/// into the first of them; those merged stay, without triangles. Returns how many were merged.
std::size_t weldVertices(model::TriangleMesh& mesh, double tolerance);

/// Returns those that are left, in their order, by their numbers before.
std::vector<std::uint32_t> dropUnusedVertices(model::TriangleMesh& mesh);

/// weldVertices, noted.
void weld(model::TriangleMesh& mesh, double tolerance, Changes& changes);

/// Drops triangles with a corner twice. Of triangles with the same corners, keeps the first.
void dropDuplicates(model::TriangleMesh& mesh, Changes& changes);

// drop_stray.cpp

/// Drops fins, and walls that divide the inside.
void dropStray(model::TriangleMesh& mesh, Changes& changes);

// orient_surface.cpp

/// Turns triangles such that neighbours agree. Fails if there is no way.
Result<void> orient(model::TriangleMesh& mesh, Changes& changes);

/// Triangles connected across edges.
struct Component {
  std::vector<std::uint32_t> triangles;
  double volume = 0;
};
std::vector<Component> componentsOf(const model::TriangleMesh& mesh,
                                    const std::vector<std::uint32_t>& mates);

/// Turns components that enclose a negative volume and are in no other. True if what remains is
/// nested otherwise than solids with cavities are.
bool faceOutward(model::TriangleMesh& mesh, Changes& changes);

// close_holes.cpp

/// Closes the surface, which is in the unit of `scale`, or fails if a hole is too wide.
Result<void> fillHoles(model::TriangleMesh& mesh, const MendSurfaceOptions& options,
                       const model::UnitScale& scale, Changes& changes);

// take_outer_surface.cpp

/// Takes the outer surface if triangles cross, or if components are nested. Closed still, it may
/// touch itself. In a build that cannot find crossings none are looked for.
Result<void> takeOuterSurface(model::TriangleMesh& mesh, bool nested, Changes& changes);

// take_apart.cpp

/// Whether what a file would keep of the mesh, with equal vertices merged, bounds a solid; in a
/// build that cannot find crossings, regardless of these.
Result<bool> isSound(const model::TriangleMesh& mesh);

/// Moves what touches itself apart.
Result<void> takeApart(model::TriangleMesh& mesh, Changes& changes);

}  // namespace t4d::edit
