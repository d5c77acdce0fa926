#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/input_file.h"
#include "formats/mesh4d/flat_bodies.h"
#include "t4d/file.h"

namespace t4d::formats {

/// The contents that a format of 4D meshes can hold. Converting to it loses the rest.
struct Mesh4dKeeps {
  bool tetrahedra = true;  ///< otherwise only their triangles
  bool doubles = true;     ///< coordinates bit for bit
  bool bodies = true;      ///< which tetrahedra are of which body
  bool names = true;       ///< of the bodies
  /// Attributes that it can hold; null: none.
  bool (*attributes)(const model::Attribute& attribute) = nullptr;
  bool metadata = false;  ///< units, the upward axis, how the mesh was made
};

/// A file format of 4D meshes, or a dialect of one. The rows are in mesh4d_formats.cpp; everything
/// that reads, writes or lists these formats goes by them.
struct Mesh4dFormat {
  std::string_view id;  ///< how users name it: "off-stella"
  std::string_view name;
  std::vector<std::string_view> extensions;  ///< with their dots, in lower case
  /// The content by which a file of this format is recognised, for users.
  std::string_view recognisedBy;
  /// Whether a file that begins with these bytes has this format.
  bool (*recognises)(std::string_view begin);
  Mesh4dKeeps keeps = {};
  /// Reads a whole file. Null: the format is not read.
  Result<LoadedMesh4d> (*read)(const InputFile& file) = nullptr;
  /// Writes a file whole or not at all. Null: the format is not written.
  Result<void> (*write)(const std::filesystem::path& path, const FlatBodies& mesh) = nullptr;
};

/// All formats but .t4d, in the order in which they are listed for users. Of those with the same
/// extension the first is the one written.
std::span<const Mesh4dFormat> mesh4dFormats();

/// The format with this id; null when there is none.
const Mesh4dFormat* mesh4dFormat(std::string_view id);

/// The format in which a file of this name is written; null when there is none.
const Mesh4dFormat* writtenMesh4dFormat(const std::filesystem::path& path);

/// The format of a file, by its content or else its extension; null when there is none, or when the
/// file cannot be read.
const Mesh4dFormat* mesh4dFormatOfFile(const std::filesystem::path& path);

/// The extensions that can be written, for messages: ".off, .4do or .mesh".
std::string writableMesh4dExtensions();

/// Reads a 4D mesh in the format `format`, or in that which its content, and where that is not
/// enough its extension, tells. Coordinates are the doubles nearest to the numbers in the file.
/// `found` is set to the format.
///
/// Fails on a file that cannot be read, has an unknown format or breaks it, has coordinates that
/// are not finite or indices out of range, or holds no tetrahedra. `where` of the error is
/// `path:LINE`, `path: byte N`, or the path alone.
Result<LoadedMesh4d> readMesh4d(const std::filesystem::path& path, const Mesh4dFormat* format,
                                const Mesh4dFormat*& found);

/// The losses of writing `mesh` in this format, a sentence each; attributes and metadata excepted,
/// which FlatBodies does not have.
std::vector<std::string> mesh4dLosses(const Mesh4dFormat& format, const FlatBodies& mesh);

}  // namespace t4d::formats
