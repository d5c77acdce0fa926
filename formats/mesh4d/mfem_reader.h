#pragma once

#include <string_view>

#include "formats/input_file.h"
#include "t4d/file.h"

namespace t4d::formats {

/// Whether text begins with `MFEM mesh v1.`.
bool isMfem(std::string_view begin);

/// Reads an MFEM mesh v1.0 of dimension 4: its boundary of tetrahedra (geometry 4), whose
/// attributes are the parts of Mesh4dBuilder::finish. If there is none, the boundary of the
/// pentatopes (geometry 8, or 6 or 7 of MFEM's branches) that are its elements: the tetrahedra of
/// which only one pentatope is beside them, facing outward.
Result<LoadedMesh4d> readMfem(const InputFile& file);

}  // namespace t4d::formats
