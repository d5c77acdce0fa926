#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "model/error.h"
#include "model/triangle_mesh.h"

namespace t4d::formats {

/// How the points and faces of a file became a mesh: other places of the same points can take their
/// part.
struct FilePoints {
  static constexpr std::uint32_t kUnused = ~std::uint32_t{0};
  /// For each point of the file, in its order, the vertex that it became; kUnused if no triangle
  /// uses it.
  std::vector<std::uint32_t> vertexOf = {};
  std::uint64_t faceCount = 0;
  /// Of the corners of all faces, in their order, by the numbers of points.
  std::uint64_t faceHash = 0;
};

/// What is read of a file besides its shape.
enum class Keep : std::uint8_t {
  Shape,  ///< nothing
  /// What it says of its surface, as attributes of vertices or, where the corners at one vertex
  /// differ, of triangles (cornerAttribute in corner_rows.h):
  /// * `color`: of .ply and .obj UInt8 sRGB, with or without opacity; of glTF (COLOR_0) linear,
  ///   UInt16, or Float32 where the file has that;
  /// * `uv`: Float32 texture coordinates, v upward (glTF: TEXCOORD_0);
  /// * of .vtp and .vtu, point data and cell data, under their own names;
  /// * `material`: of the triangles of an .obj with `usemtl`, UInt32 numbers in
  ///   LoadedMesh::materials.
  Attributes,
};

struct LoadedMesh {
  model::TriangleMesh mesh;  ///< with attributes as far as they are kept
  /// What was changed while reading, a sentence each: dropped triangles, unused vertices, ...; of
  /// attributes that are kept, what had to be filled in, and what was left out.
  std::vector<std::string> notices;
  /// What the file holds and the mesh does not, a sentence each. Only glTF and VTK files have
  /// losses; what the other formats say of the look of a surface (normals, texture coordinates,
  /// colours, materials) is skipped without one.
  std::vector<std::string> losses = {};
  /// Files that were read besides the one named: the buffers of a .gltf.
  std::vector<std::filesystem::path> otherFiles = {};
  FilePoints points = {};
  std::vector<std::string> materials = {};  ///< names; the first is "", for no material
};

/// Reads .stl (text or binary), .obj, .ply (text or binary, faces and triangle strips), .off, .vtp,
/// .vtu (a surface, or the boundary of volume cells), .gltf or .glb, by the extension.
///
/// Coordinates are the doubles nearest to the numbers in the file, in its own units and axes (glTF:
/// the default scene in metres, y up, with its node transforms, at rest). Vertices with equal
/// coordinates become one; the others keep their order. Polygons become triangles. Triangles with
/// two equal corners and vertices of no triangle are dropped, with a notice. Does not check whether
/// the mesh is closed.
///
/// Fails on a file that cannot be read, breaks its format, has coordinates that are not finite or
/// indices out of range, or holds no triangles. `where` of the error is `path:LINE`,
/// `path: byte N`, for glTF `path: ELEMENT`, or the path alone.
Result<LoadedMesh> readTriangleMesh(const std::filesystem::path& path, Keep keep = Keep::Shape);

}  // namespace t4d::formats
