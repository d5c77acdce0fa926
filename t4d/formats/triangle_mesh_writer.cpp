#include "t4d/formats/triangle_mesh_writer.h"

#include <fmt/format.h>

#include "t4d/formats/output_file.h"
#include "t4d/formats/triangle_mesh_formats.h"
#include "t4d/formats/written_mesh.h"

namespace t4d::formats {

Result<std::vector<std::string>> writeTriangleMeshes(const std::filesystem::path& path,
                                                     std::span<const NamedMesh> meshes,
                                                     const MeshWriteOptions& options) {
  const TriangleMeshFormat* format = triangleMeshFormat(path);
  if (format == nullptr || format->write == nullptr) {
    return fail(ErrorCode::Unsupported,
                fmt::format("unsupported output extension; a triangle mesh can be written as {}",
                            writableTriangleMeshExtensions()),
                path.string());
  }
  for (const NamedMesh& named : meshes) {
    if (auto good = checkWritable(named); !good) return inFile(path, good.error());
  }
  auto file = OutputFile::create(path);
  if (!file) return pass(file.error());
  auto lost = format->write(*file, meshes, options);
  if (!lost) return inFile(path, lost.error());
  if (auto done = file->commit(); !done) return pass(done.error());
  return lost;
}

}  // namespace t4d::formats
