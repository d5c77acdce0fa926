#pragma once

#include <string_view>

#include "formats/input_file.h"
#include "t4d/file.h"

namespace t4d::formats {

/// Whether text begins with `MeshVersionFormatted`.
bool isMedit(std::string_view begin);

/// Reads a Medit mesh as text (.mesh) or binary, of dimension 4: Vertices and Tetrahedra. The
/// references of the tetrahedra are the parts of Mesh4dBuilder::finish. Other elements are skipped;
/// edges, triangles and quadrilaterals without a loss.
Result<LoadedMesh4d> readMedit(const InputFile& file);

}  // namespace t4d::formats
