#pragma once

#include <filesystem>

#include "formats/mesh4d/flat_bodies.h"

namespace t4d::formats {

/// Writes an MFEM mesh v1.0 of dimension 4 that has boundary elements alone; the attribute of each
/// is the number of its body, from 1.
Result<void> writeMfem(const std::filesystem::path& path, const FlatBodies& mesh);

}  // namespace t4d::formats
