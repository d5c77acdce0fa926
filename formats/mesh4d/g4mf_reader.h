#pragma once

#include <string_view>

#include "formats/input_file.h"
#include "t4d/file.h"

/// Good 4D Model Format, the draft, and its older keys: `cells` for `simplexes`, vertices in the
/// surface, `mesh` of a node for `meshInstance`.
namespace t4d::formats {

bool isG4mfText(std::string_view begin);
bool isG4mfBinary(std::string_view begin);

/// Reads text or binary: each node with a mesh becomes a body, placed by its `position` and `basis`
/// or `rotor` and `scale`, and those of the nodes above it. Without nodes, each mesh becomes
/// one. Blend shapes move vertices by the amounts of the instance or else of the mesh. The
/// polyhedra of a surface without simplexes become tetrahedra (polyhedra.h); one without either is
/// not read. Nodes that are not visible are skipped with a notice, edges, normals, texture maps and
/// topology without; materials, lights, cameras, physics, skins and models of other files are a
/// loss.
Result<LoadedMesh4d> readG4mf(const InputFile& file);

}  // namespace t4d::formats
