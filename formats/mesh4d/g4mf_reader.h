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
/// one. Blend shapes move vertices by the amounts of the instance or else of the mesh. Edges,
/// normals, texture maps and topology are skipped without a loss; materials, lights, cameras,
/// shapes, skins and models of other files are one. A surface without simplexes is not read.
Result<LoadedMesh4d> readG4mf(const InputFile& file);

}  // namespace t4d::formats
