#pragma once

#include "formats/input_file.h"
#include "t4d/surface.h"

namespace t4d::formats {

/// Reads a Wavefront OBJ file: `v` and `f` statements; groups, materials, lines and curves are
/// ignored.
Result<LoadedMesh> readObj(const InputFile& file, Keep keep = Keep::Shape);

}  // namespace t4d::formats
