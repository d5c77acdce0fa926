#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/input_file.h"
#include "formats/output_file.h"
#include "t4d/surface.h"

namespace t4d::formats {

/// A file format of triangle meshes, by one of its extensions. The rows are in
/// formats/triangle_mesh_rows.cpp, above all readers and writers; everything that reads, writes
/// or lists these formats goes by them.
struct TriangleMeshFormat {
  std::string_view extension;  ///< with its dot, in lower case
  std::string_view name;

  /// Reads a whole file. Null: the format is not read.
  Result<LoadedMesh> (*read)(const InputFile& file, Keep keep) = nullptr;

  /// Writes meshes that `writeTriangleMeshes` has checked, and returns a line for each loss. Does
  /// not commit the file. `where` of an error names the mesh, or is empty; the file's own errors
  /// name the file. Null: the format is not written.
  Result<std::vector<std::string>> (*write)(OutputFile& file, std::span<const NamedMesh> meshes,
                                            const MeshWriteOptions& options) = nullptr;

  /// The format has units and axes of its own: `write` uses `MeshWriteOptions::placement`.
  bool placed = false;

  /// The contents that it holds besides triangles, for users.
  std::vector<std::string_view> keeps = {};
};

/// All formats, in the order in which they are listed for users.
std::span<const TriangleMeshFormat> triangleMeshFormats();

/// The format of a file with this name, by its extension; null when there is none.
const TriangleMeshFormat* triangleMeshFormat(const std::filesystem::path& path);

/// Fails for a file that is no triangle mesh by its extension, or one that is written, not read.
Result<void> checkMeshExtension(const std::filesystem::path& path);

/// The extensions that can be written.
std::vector<std::string_view> writableTriangleMeshes();

/// The extensions that can be read and those that can be written, for messages: ".stl, .obj or
/// .ply".
std::string readableTriangleMeshExtensions();
std::string writableTriangleMeshExtensions();

}  // namespace t4d::formats
