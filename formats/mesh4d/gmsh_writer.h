#pragma once

#include <filesystem>

#include "formats/mesh4d/flat_bodies.h"

namespace t4d::formats {

/// Writes a Gmsh mesh, MSH 4.1 as text: nodes (x, y, z), tetrahedra, and the times of the nodes as
/// `$NodeData "time"`. Each body is a volume, and a physical group with its name.
Result<void> writeGmsh(const std::filesystem::path& path, const FlatBodies& mesh);

}  // namespace t4d::formats
