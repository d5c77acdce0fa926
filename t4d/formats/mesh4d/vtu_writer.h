#pragma once

#include <filesystem>

#include "t4d/formats/mesh4d/flat_bodies.h"

namespace t4d::formats {

/// Writes a VTK file (.vtu) of an unstructured grid: points (x, y, z), point data `t`, tetrahedra,
/// and for several bodies cell data `body`, with field data `body_names`. Arrays are appended as
/// raw bytes, compressed with zlib in blocks, on all threads. Takes memory for some blocks and 8
/// bytes a vertex.
///
/// Fails if the path is a pipe: the sizes of the blocks come before them.
Result<void> writeVtu(const std::filesystem::path& path, const FlatBodies& mesh);

}  // namespace t4d::formats
