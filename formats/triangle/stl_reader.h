#pragma once

#include "formats/input_file.h"
#include "t4d/surface.h"

namespace t4d::formats {

/// Reads a text or a binary STL file. A file is binary when its size fits the count at byte 80,
/// whatever its header says. Normals are ignored.
Result<LoadedMesh> readStl(const InputFile& file, Keep keep = Keep::Shape);

}  // namespace t4d::formats
