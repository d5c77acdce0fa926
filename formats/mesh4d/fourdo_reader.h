#pragma once

#include <string_view>

#include "formats/input_file.h"
#include "t4d/file.h"

namespace t4d::formats {

/// Whether text begins with `4DO`, in upper or lower case.
bool is4do(std::string_view begin);

/// Reads 4DO, version 1 or 2. Right, up, forward and over of the file's `orient` become x, y, z and
/// t. Normals, texture coordinates and colours are skipped without a loss; polylines are one. The
/// grouping of tetrahedra into cells is not kept.
Result<LoadedMesh4d> read4do(const InputFile& file);

}  // namespace t4d::formats
