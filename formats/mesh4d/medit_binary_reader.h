#pragma once

#include <string_view>

#include "formats/input_file.h"
#include "t4d/file.h"

namespace t4d::formats {

/// Whether bytes begin as a binary Medit mesh, in either byte order.
bool isMeditBinary(std::string_view begin);

/// Reads a binary Medit mesh (.meshb) of dimension 4, versions 1 to 4 of libMeshb's container: each
/// keyword with its number, the offset of the next keyword, a count and elements. Otherwise as
/// readMedit.
Result<LoadedMesh4d> readMeditBinary(const InputFile& file);

}  // namespace t4d::formats
