#include "t4d/formats/triangle_mesh_reader.h"

#include <new>

#include <fmt/format.h>

#include "t4d/formats/triangle_mesh_formats.h"

namespace t4d::formats {

Result<LoadedMesh> readTriangleMesh(const std::filesystem::path& path) {
  const auto file = readInputFile(path);
  if (!file) return pass(file.error());
  const TriangleMeshFormat* format = triangleMeshFormat(path);
  if (format == nullptr || format->read == nullptr) {
    const std::string extension = path.extension().string();
    return fail(
        ErrorCode::Unsupported,
        fmt::format("{} is not the extension of a triangle mesh: {}",
                    extension.empty() ? "(none)" : extension, readableTriangleMeshExtensions()),
        path.string(), Remedy::OtherFormat);
  }
  try {
    return format->read(*file);
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::Failed, "the mesh does not fit in memory", path.string());
  }
}

}  // namespace t4d::formats
