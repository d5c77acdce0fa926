#pragma once

#include "t4d/formats/input_file.h"
#include "t4d/formats/triangle_mesh_reader.h"

namespace t4d::formats {

/// Reads a text or a binary STL file. Binary is a file whose size fits the count at byte 80,
/// whatever its header says; normals are ignored.
Result<LoadedMesh> readStl(const InputFile& file);

}  // namespace t4d::formats
