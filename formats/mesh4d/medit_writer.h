#pragma once

#include <filesystem>

#include "formats/mesh4d/flat_bodies.h"

namespace t4d::formats {

/// Writes a Medit mesh as text, version 2 (double precision), dimension 4. The reference of a
/// tetrahedron, and of a vertex, is the number of its body, from 1.
Result<void> writeMedit(const std::filesystem::path& path, const FlatBodies& mesh);

}  // namespace t4d::formats
