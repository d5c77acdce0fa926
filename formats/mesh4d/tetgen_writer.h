#pragma once

#include <filesystem>

#include "formats/mesh4d/flat_bodies.h"

namespace t4d::formats {

/// Writes a TetGen mesh: `NAME.node` and `NAME.ele`, of which `path` names either. Numbers count
/// from 1; the time is the attribute of a point, the number of its body that of a tetrahedron.
Result<void> writeTetGen(const std::filesystem::path& path, const FlatBodies& mesh);

}  // namespace t4d::formats
