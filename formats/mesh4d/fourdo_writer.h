#pragma once

#include <filesystem>

#include "formats/mesh4d/flat_bodies.h"

namespace t4d::formats {

/// Writes 4DO, version 1.
Result<void> write4do(const std::filesystem::path& path, const FlatBodies& mesh);

}  // namespace t4d::formats
