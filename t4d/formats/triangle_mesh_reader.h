#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "t4d/model/error.h"
#include "t4d/model/triangle_mesh.h"

namespace t4d::formats {

struct LoadedMesh {
  model::TriangleMesh mesh;
  /// What was changed while reading, a sentence each: dropped triangles, unused vertices, ...
  std::vector<std::string> notices;
};

/// Whether the extension is one that readTriangleMesh knows.
bool canReadTriangleMesh(const std::filesystem::path& path);

/// Reads .stl (text or binary), .obj, .ply (text or binary), .off, .gltf or .glb, told apart by the
/// extension.
///
/// Coordinates are the nearest doubles of what the file says, in its own units and axes (glTF: the
/// default scene in metres, y up, with its node transforms, without its animations). Vertices with
/// equal coordinates become one; the others keep their order. Polygons become triangles. Triangles
/// with two equal corners and vertices of no triangle are dropped, with a notice. Whether the mesh
/// is closed is not judged here.
///
/// Fails on a file that cannot be read, breaks its format, has coordinates that are not finite or
/// indices out of range, or holds no triangles. `where` of the error is `path:LINE`,
/// `path: byte N`, for glTF `path: ELEMENT`, or the path alone.
Result<LoadedMesh> readTriangleMesh(const std::filesystem::path& path);

}  // namespace t4d::formats
