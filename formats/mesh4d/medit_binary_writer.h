#pragma once

#include <filesystem>

#include "formats/mesh4d/flat_bodies.h"

namespace t4d::formats {

/// Writes a binary Medit mesh (.meshb) of dimension 4, little-endian: version 3, or 4 if numbers
/// need more than 32 bits. The reference of an element is its body, from 1.
Result<void> writeMeditBinary(const std::filesystem::path& path, const FlatBodies& mesh);

}  // namespace t4d::formats
