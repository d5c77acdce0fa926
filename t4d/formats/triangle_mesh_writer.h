#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "t4d/model/error.h"
#include "t4d/model/triangle_mesh.h"

namespace t4d::formats {

struct NamedMesh {
  std::string name;
  model::TriangleMesh mesh;
};

struct MeshWriteOptions {
  /// Write vertex and triangle attributes where the format has room for them.
  bool attributes = false;
};

/// Writes by extension, replacing a file that exists:
/// * .stl: binary, float32; several meshes become one;
/// * .obj: text, each coordinate the shortest decimal that reads back the same, an `o` group a
/// mesh;
/// * .ply: binary little-endian, float64; several meshes become one; attributes, if asked for, as
///   properties of the vertices and faces.
///
/// Meshes without triangles are written. Returns a line for each attribute that was asked for and
/// could not be written; empty when nothing was lost. Fails on an unknown extension, coordinates
/// that are not finite or beyond float32 where that is written, indices out of range, more than the
/// format can count, and errors of the file system.
Result<std::vector<std::string>> writeTriangleMeshes(const std::filesystem::path& path,
                                                     std::span<const NamedMesh> meshes,
                                                     const MeshWriteOptions& options = {});

/// True for an extension that `writeTriangleMeshes` knows.
bool canWriteTriangleMesh(const std::filesystem::path& path);

/// Those extensions, for messages: ".stl, .obj, .ply".
std::string writableTriangleMeshExtensions();

}  // namespace t4d::formats
