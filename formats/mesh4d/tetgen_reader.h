#pragma once

#include "formats/input_file.h"
#include "t4d/file.h"

namespace t4d::formats {

/// Reads a TetGen mesh by either of its files: `NAME.node` has x, y, z and one attribute, the time;
/// `NAME.ele` has tetrahedra, of which an attribute is the part of Mesh4dBuilder::finish.
Result<LoadedMesh4d> readTetGen(const InputFile& file);

/// Reads a TetGen mesh from its two files in memory.
Result<LoadedMesh4d> readTetGen(const InputFile& nodes, const InputFile& elements);

}  // namespace t4d::formats
