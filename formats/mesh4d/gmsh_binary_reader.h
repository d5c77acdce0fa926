#pragma once

#include <string_view>

#include "formats/input_file.h"
#include "t4d/file.h"

namespace t4d::formats {

/// Whether a file begins as a binary Gmsh mesh: its first line is `$MeshFormat`, and the second
/// number of the next is 1.
bool isGmshBinary(std::string_view begin);

/// Reads a binary Gmsh mesh, MSH 4.1 in either byte order; otherwise as readGmsh.
Result<LoadedMesh4d> readGmshBinary(const InputFile& file);

}  // namespace t4d::formats
