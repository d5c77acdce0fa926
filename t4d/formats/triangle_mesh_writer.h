#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "t4d/formats/vertex_normals.h"
#include "t4d/model/error.h"
#include "t4d/model/triangle_mesh.h"

namespace t4d::formats {

/// Red, green, blue and opacity from 0 to 1; red, green and blue are linear, not sRGB.
using Color = std::array<double, 4>;

struct NamedMesh {
  std::string name;
  model::TriangleMesh mesh;
  std::optional<Color> color = {};
};

/// From the mesh's units and axes to those of glTF: metres, y up, right-handed. It becomes the
/// transform of one root node, above all others, and is stated in that node's `extras`; coordinates
/// are written as they are.
struct GltfPlacement {
  double metresPerUnit = 1;
  bool zUp = false;  ///< the mesh's z is up: turn by -90 degrees about x, which makes it glTF's y
  std::string extras = {};  ///< a JSON object whose members join the root's extras, or ""
};

struct MeshWriteOptions {
  /// Write vertex and triangle attributes where the format has room for them.
  bool attributes = false;
  /// For formats with units and axes of their own: glTF.
  GltfPlacement placement = {};
  /// Subtracted from all coordinates before they are written: float32 is coarse far from 0.
  model::Point3 center = model::Point3::Zero();
  /// Where the origin of the given coordinates lies, if they were moved before.
  model::Point3 origin = model::Point3::Zero();
  /// The time of the solid, for formats that have a place for it: .vtp.
  std::optional<double> time = {};
  /// Write normals; without them, viewers shade flat.
  std::optional<NormalStyle> normals = {};
};

/// Writes a file by its extension, replacing one that exists:
/// * .stl: binary, float32; several meshes become one;
/// * .obj: text, each coordinate the shortest decimal that reads back the same, an `o` group for
///   each mesh;
/// * .ply: binary little-endian, float64; several meshes become one; attributes, if asked for, as
///   properties of the vertices and faces;
/// * .vtp: VTK polygonal data, float64; several meshes become one, with the cell data `body` and
///   their names as field data `body_names`; attributes, if asked for, as point and cell data; the
///   time as field data `TimeValue`;
/// * .off: text with the same decimals; several meshes become one;
/// * .glb (binary), .gltf (text, the geometry in it as a data URI): float32, a node and a mesh for
///   each mesh that has triangles. Attributes, if asked for, of
///   vertices with one to four components, as float32 attributes `_NAME`.
///
/// Normals, if asked for, are those of vertices, which are repeated where several meet; in .obj
/// they have a list of their own, and .stl has one for each triangle in any case. The colour of a
/// mesh is a material in glTF, 8-bit sRGB colours of vertices in .ply, the cell data `color` in
/// .vtp and colours after the coordinates in .obj.
///
/// Where the file's origin is not that of the original coordinates, it says so: glTF by the
/// translation of the node above all meshes, the others by a comment "origin X Y Z".
///
/// Meshes without triangles are written, except to glTF, which does not allow them. Returns a line
/// for each attribute, normals and colours that were asked for and could not be written, and one if
/// rounding to float32 makes triangles flat or turns them over; empty when nothing was lost. Fails
/// on an unknown extension, coordinates that are not finite or beyond float32 where that is
/// written, indices out of range, more than the format can count or hold (4 GiB in a .glb, 1.5 GiB
/// of geometry in a .gltf), names that are not UTF-8 and extras that are not a JSON object (glTF),
/// and errors of the file system.
Result<std::vector<std::string>> writeTriangleMeshes(const std::filesystem::path& path,
                                                     std::span<const NamedMesh> meshes,
                                                     const MeshWriteOptions& options = {});

}  // namespace t4d::formats
