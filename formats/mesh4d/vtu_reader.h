#pragma once

#include <string_view>

#include "formats/input_file.h"
#include "t4d/file.h"

namespace t4d::formats {

/// Whether text is XML with a `VTKFile` of an unstructured grid.
bool isVtu(std::string_view begin);

/// Reads a VTK file (.vtu) of an unstructured grid, as text or binary, inline or appended,
/// compressed with zlib, LZ4 or LZMA or not, in either byte order: points (x, y, z), and their
/// times from point data named `t` or `time`. Hexahedra, voxels, wedges and pyramids become
/// tetrahedra by pulling (polyhedron.h), without orientation. Cell data `body` are the parts of
/// Mesh4dBuilder::finish, field data `body_names` their names. Cells of lower dimension and other
/// data are not read, which is a loss.
Result<LoadedMesh4d> readVtu(const InputFile& file);

}  // namespace t4d::formats
