#pragma once

#include "formats/input_file.h"
#include "t4d/surface.h"

namespace t4d::formats {

/// Reads an OFF file, `OFF` with any of the prefixes `ST`, `C` and `N`. Normals, colours and
/// texture coordinates are ignored. `4OFF`, `nOFF` and binary OFF are refused by name.
Result<LoadedMesh> readOff(const InputFile& file, Keep keep = Keep::Shape);

}  // namespace t4d::formats
