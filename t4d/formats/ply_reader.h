#pragma once

#include "t4d/formats/input_file.h"
#include "t4d/formats/triangle_mesh_reader.h"

namespace t4d::formats {

/// Reads a PLY file, text or binary of either byte order: positions of the `vertex` element and
/// lists of the `face` element; other elements and properties are skipped.
Result<LoadedMesh> readPly(const InputFile& file);

}  // namespace t4d::formats
