#pragma once

#include <filesystem>

#include "formats/mesh4d/flat_bodies.h"

/// Good 4D Model Format, the draft: like glTF, in any number of dimensions. A node, a mesh and a
/// surface for each body, the node named after it; vertices as float64.
namespace t4d::formats {

/// Writes text (.g4tf), the data as a Base64 URI. Takes memory for the whole text.
Result<void> writeG4mfText(const std::filesystem::path& path, const FlatBodies& mesh);

/// Writes a binary file (.g4b), the data as one chunk without compression.
Result<void> writeG4mfBinary(const std::filesystem::path& path, const FlatBodies& mesh);

}  // namespace t4d::formats
