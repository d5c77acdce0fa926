#pragma once

#include "formats/input_file.h"
#include "t4d/surface.h"

namespace t4d::formats {

/// Reads a PLY file, text or binary in either byte order: the positions of the element `vertex`,
/// the polygons of `face` and the strips of `tristrips`, where -1 ends a strip. A file may have
/// both faces and strips. Other elements and properties, normals and colours among them, are
/// skipped.
Result<LoadedMesh> readPly(const InputFile& file, Keep keep = Keep::Shape);

}  // namespace t4d::formats
