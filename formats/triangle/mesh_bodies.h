#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "t4d/error.h"
#include "t4d/surface.h"

namespace t4d::formats {

/// The lines that divide an .obj into bodies.
enum class BodiesBy : std::uint8_t {
  Object,  ///< its objects: `o NAME`
  Group,   ///< its groups: `g NAME`, where several names are one
};

struct LoadedBodies {
  std::vector<NamedMesh> bodies = {};
  std::vector<std::string> notices = {};    ///< as LoadedMesh
  std::vector<std::string> materials = {};  ///< as LoadedMesh
};

/// Reads an .obj as several bodies, in the order in which they begin. Faces under the same name are
/// one body, wherever they are in the file; those before any name are one named after the file, and
/// those under an empty name one named "default". Otherwise as readTriangleMesh. Each body has
/// vertices of its own. Fails for other formats.
Result<LoadedBodies> readMeshBodies(const std::filesystem::path& path, BodiesBy by,
                                    Keep keep = Keep::Shape);

}  // namespace t4d::formats
