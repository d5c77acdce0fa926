#pragma once

#include <string_view>

#include "formats/input_file.h"
#include "t4d/file.h"

namespace t4d::formats {

/// Whether text begins with `$MeshFormat`, and is not of a binary file.
bool isGmsh(std::string_view begin);

/// Reads a Gmsh mesh, MSH 4.1 as text or binary: nodes (x, y, z), their times from `$NodeData
/// "time"`, and the tetrahedra of four nodes. The parts of Mesh4dBuilder::finish are the volumes
/// (entities of dimension 3), named by their physical group. Points, lines and triangles are
/// skipped without a loss; so is node data of other names, with one.
Result<LoadedMesh4d> readGmsh(const InputFile& file);

}  // namespace t4d::formats
