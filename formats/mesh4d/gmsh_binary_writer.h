#pragma once

#include <filesystem>

#include "formats/mesh4d/flat_bodies.h"

namespace t4d::formats {

/// Writes a binary Gmsh mesh, MSH 4.1, little-endian; otherwise as writeGmsh. Fails if there are
/// 2^31 vertices or more, which its node data cannot number.
Result<void> writeGmshBinary(const std::filesystem::path& path, const FlatBodies& mesh);

}  // namespace t4d::formats
