#pragma once

#include <filesystem>

#include "formats/mesh4d/flat_bodies.h"

namespace t4d::formats {

/// Writes a VTK file (.vtu) of an unstructured grid: points (x, y, z), point data `t`, tetrahedra
/// (turnOver), field data `body_names`, the bytes of each name and a 0 after it, and for several
/// bodies cell data `body`. Attributes that the bodies have in common are point data and cell data
/// (FlatBodies::findAttributes). Arrays are appended as raw bytes, compressed with zlib in blocks,
/// on all threads. Takes memory for some blocks and 8 bytes a vertex.
///
/// Fails if the path is a pipe: the sizes of the blocks come before them.
Result<void> writeVtu(const std::filesystem::path& path, const FlatBodies& mesh);

/// Whether an attribute can be data of the grid: those that have the name of what is there anyway
/// cannot.
bool keptInVtu(const model::Attribute& attribute);

/// Exchanges two corners of a tetrahedron: VTK's contours of `t` face outward if the corners of
/// each are the other way round than ours. Files in which they are have field data of this name.
void turnOver(model::Cell& cell);
inline constexpr const char* kOutwardContours = "contours_face_outward";

}  // namespace t4d::formats
