#pragma once

/// Triangle meshes: the input of a sweep, and slices; reading and writing them.

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "t4d/error.h"
#include "t4d/mesh.h"

namespace t4d::model {

using Triangle = std::array<std::uint32_t, 3>;

/// A triangle mesh in space: the input of a sweep, or a slice. Triangles of a solid's surface are
/// counter-clockwise seen from outside.
struct TriangleMesh {
  std::vector<Point3> vertices = {};
  std::vector<Triangle> triangles = {};
  /// Domain::Cell means one row per triangle.
  std::vector<Attribute> attributes = {};
};

Bounds3 boundsOf(const TriangleMesh& mesh);

/// The volume that a closed mesh encloses, positive if its triangles face outward. Summed about the
/// centre of the bounds, so that a mesh far from the origin loses no precision.
double signedVolume(const TriangleMesh& mesh);

double surfaceArea(const TriangleMesh& mesh);

/// True if every edge is traversed equally often in both directions, so that the mesh bounds a
/// solid. The empty mesh is closed.
bool isClosed(const TriangleMesh& mesh);

}  // namespace t4d::model

namespace t4d::formats {

/// How surfaces are shaded. Triangles that share an edge share their normals along it if the angle
/// between their planes is at most `creaseDegrees`: 180 is smooth everywhere. Flat: never.
struct NormalStyle {
  bool flat = false;
  double creaseDegrees = 180;
};

/// The origins of a mesh in the points and faces of a file: other places of the same points can
/// take their part.
struct FilePoints {
  static constexpr std::uint32_t kUnused = ~std::uint32_t{0};
  /// For each point of the file, in its order, the vertex that it became; kUnused if no triangle
  /// uses it.
  std::vector<std::uint32_t> vertexOf = {};
  std::uint64_t faceCount = 0;
  /// A hash of the corners of all faces, in their order, by the numbers of points.
  std::uint64_t faceHash = 0;
};

/// The contents of a file that are read besides its shape.
enum class Keep : std::uint8_t {
  Shape,  ///< nothing
  /// What it says of its surface, as attributes of vertices or, where the corners at one vertex
  /// differ, of triangles (cornerAttribute in corner_rows.h):
  /// * `color`: of .ply and .obj UInt8 sRGB, with or without opacity; of glTF (COLOR_0) linear,
  ///   UInt16, or Float32 where the file has that;
  /// * `uv`: Float32 texture coordinates, v upward (glTF: TEXCOORD_0);
  /// * of .vtp and .vtu, point data and cell data, under their own names;
  /// * `material`: of the triangles of an .obj with `usemtl` and of a glTF with materials, UInt32
  ///   numbers in LoadedMesh::materials.
  Attributes,
};

struct LoadedMesh {
  model::TriangleMesh mesh;  ///< with attributes as far as they are kept
  /// What was changed while reading, a sentence each: dropped triangles, unused vertices, ...; of
  /// attributes that are kept, what had to be filled in, and what was left out.
  std::vector<std::string> notices;
  /// Contents of the file that the mesh does not have, a sentence each. Only glTF and VTK files
  /// have losses; other formats' normals, texture coordinates, colours and materials are skipped
  /// without one.
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

/// Red, green, blue and opacity from 0 to 1; red, green and blue are linear, not sRGB.
using Color = std::array<double, 4>;

/// A colour for each vertex or for each triangle of a mesh: numbers as those of Color.
struct MeshColors {
  model::Domain domain = model::Domain::Vertex;
  std::vector<std::array<float, 4>> colors = {};
};

struct NamedMesh {
  std::string name = {};
  model::TriangleMesh mesh = {};
  std::optional<Color> color = {};
  std::optional<MeshColors> colors = {};  ///< instead of `color`
  /// Attributes of corners (model::kCornersOf) are those of the corners of these triangles, as in a
  /// light slice, and not of triangles that these were cut from.
  bool ownCorners = false;
};

/// Maps the mesh's units and axes to those of glTF: metres, y up, right-handed. It becomes the
/// transform of one root node, above all others, and is stated in that node's `extras`; coordinates
/// are written as they are.
struct GltfPlacement {
  double metresPerUnit = 1;
  bool zUp = false;  ///< the mesh's z is up: turn by -90 degrees about x, which makes it glTF's y
  std::string extras = {};  ///< a JSON object whose members join the root's extras, or ""
};

/// Positions as whole numbers of `step()` from `bounds.min`, from 0 to 2^bits - 1. No coordinate is
/// further than half a step from its place, up to the rounding of who reads it.
struct Quantization {
  int bits = 16;  ///< from 1 to 16
  /// The bounds of all vertices that are written: all frames share one grid.
  model::Bounds3 bounds = {};

  double step() const;
};

/// The encoding of numbers in glTF.
struct GltfEncoding {
  /// KHR_mesh_quantization: positions as 16-bit integers, normals as 8-bit ones.
  std::optional<Quantization> quantization = {};
  /// EXT_meshopt_compression, without loss. Fails in a build without meshoptimizer.
  bool meshopt = false;
  /// FlipbookWriter shows frames by KHR_node_visibility and KHR_animation_pointer, and not by their
  /// scales. Both are marked as required: a viewer without them would show all frames at once.
  bool visibility = false;
  /// The maximum size of a .glb, whose length is a 32-bit number. A .gltf has at most 1.5 GiB of
  /// numbers, or the document would be too large for readers.
  std::uint64_t maxBytes = 0xffffffff;
};

/// The encoding of USD.
struct UsdEncoding {
  /// Readers of text take many times as much memory as a file has bytes.
  std::uint64_t maxBytes = std::uint64_t{1} << 30U;
  /// Makes the file a clip of a value clip set, whose values are samples at this time code, ...
  std::optional<double> timeCode = {};
  double timeCodesPerSecond = 24;
  /// ... and which has these bodies, also those that are not there.
  std::vector<std::string> bodies = {};
};

/// True in a build that can write EXT_meshopt_compression.
bool hasMeshopt();

struct MeshWriteOptions {
  /// Write vertex and triangle attributes where the format has room for them.
  bool attributes = false;
  /// Names that the attribute `material` of triangles numbers (LoadedMesh::materials), for formats
  /// that have materials: glTF and .obj.
  std::vector<std::string> materials = {};
  /// The units and axes in glTF and USD, which have their own.
  GltfPlacement placement = {};
  /// Subtracted from all coordinates before they are written: float32 is coarse far from 0.
  model::Point3 center = model::Point3::Zero();
  /// The position of the origin of the given coordinates, if they were moved before.
  model::Point3 origin = model::Point3::Zero();
  /// The time of the solid, for formats that have a place for it: .vtp.
  std::optional<double> time = {};
  /// Write normals; without them, viewers shade flat.
  std::optional<NormalStyle> normals = {};
  GltfEncoding gltf = {};
  UsdEncoding usd = {};
};

/// Writes a file by its extension, replacing one that exists:
/// * .stl: binary, float32; several meshes become one;
/// * .obj: text, each coordinate the shortest decimal that reads back the same, an `o` group for
///   each mesh; if attributes are asked for, texture coordinates, `uv` of vertices or corners,
///   colours of vertices, `color` as three bytes, and `usemtl` for the materials of triangles;
/// * .ply: binary little-endian, float64; several meshes become one; attributes, if asked for, as
///   properties of the vertices and faces: of vertices, `color` as `red`, `green`, `blue` and
///   `alpha`, and `uv` as `s` and `t`;
/// * .vtp: VTK polygonal data, float64; several meshes become one, with the cell data `body` and
///   their names as field data `body_names`; attributes, if asked for, as point and cell data; the
///   time as field data `TimeValue`;
/// * .off: text with the same decimals; several meshes become one;
/// * .glb (binary), .gltf (text, the geometry in it as a data URI): float32, a node and a mesh for
///   each mesh that has triangles. Attributes, if asked for, of
///   vertices with one to four components, as float32 attributes `_NAME`, and `uv` as `TEXCOORD_0`;
///   attributes of the triangles' own corners, for which vertices are repeated; and a primitive for
///   each material of the triangles, with a grey material of that name;
/// * .usda (text), .usdz (the same in a package): float32, a Mesh for each mesh. Attributes, if
///   asked for, as primvars; a vertex attribute `velocity` as `velocities`.
///
/// Normals, if asked for, are those of vertices, which are repeated where several meet; in .obj
/// they have a list of their own, USD has them by corner, and .stl one for each triangle in any
/// case. The colour of a mesh is a material in glTF, `displayColor` in USD, 8-bit sRGB colours of
/// vertices in .ply, the cell data `color` in .vtp, colours after the coordinates in .obj and those
/// of triangles in .off. Colours of vertices or triangles are those in .ply, .vtp, .off and USD;
/// glTF and .obj have colours of vertices only: in glTF vertices are repeated where triangles of
/// several colours meet.
///
/// Where the file's origin is not that of the original coordinates, it says so: glTF and USD by the
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

/// Writes each mesh to a file of its own, as writeTriangleMeshes does. The files are in one folder;
/// all appear together, or none. The lines that it returns begin with the path of their file.
Result<std::vector<std::string>> writeEachTriangleMesh(std::span<const std::filesystem::path> paths,
                                                       std::span<const NamedMesh> meshes,
                                                       const MeshWriteOptions& options = {});

}  // namespace t4d::formats
