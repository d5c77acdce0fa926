#pragma once

#include <filesystem>

#include "formats/mesh4d/flat_bodies.h"

/// OFF files of 4D meshes in three dialects: see off4d_reader.h.
namespace t4d::formats {

/// Faces in the order of their corners, and for each tetrahedron the faces opposite its corners, in
/// their order. Takes some 100 bytes of memory for each tetrahedron.
Result<void> writeStellaOff(const std::filesystem::path& path, const FlatBodies& mesh);

Result<void> writeIjkOff(const std::filesystem::path& path, const FlatBodies& mesh);

/// Writes `nOFF`: the triangles alone.
Result<void> writeGeomviewOff(const std::filesystem::path& path, const FlatBodies& mesh);

}  // namespace t4d::formats
