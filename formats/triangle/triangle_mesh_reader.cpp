#include <new>

#include "formats/triangle/triangle_mesh_formats.h"
#include "t4d/surface.h"

namespace t4d::formats {

Result<LoadedMesh> readTriangleMesh(const std::filesystem::path& path, Keep keep) {
  const auto file = readInputFile(path);
  if (!file) return file.error();
  if (auto known = checkMeshExtension(path); !known) return known.error();
  try {
    return triangleMeshFormat(path)->read(*file, keep);
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::Failed, "the mesh does not fit in memory", path.string());
  }
}

}  // namespace t4d::formats
