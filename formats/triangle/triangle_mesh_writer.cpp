#include <fmt/format.h>

#include "formats/output_file.h"
#include "formats/triangle/triangle_mesh_formats.h"
#include "formats/triangle/written_mesh.h"
#include "t4d/surface.h"

namespace t4d::formats {
namespace {

using Lines = std::vector<std::string>;

/// Writes the bytes of a file that is yet to be committed.
Result<Lines> fill(const std::filesystem::path& path, std::span<const NamedMesh> meshes,
                   const MeshWriteOptions& options, std::vector<OutputFile>& files) {
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
  if (!file) return file.error();
  auto lost = format->write(*file, meshes, options);
  if (!lost) return inFile(path, lost.error());
  files.push_back(std::move(*file));
  return lost;
}

}  // namespace

Result<Lines> writeTriangleMeshes(const std::filesystem::path& path,
                                  std::span<const NamedMesh> meshes,
                                  const MeshWriteOptions& options) {
  std::vector<OutputFile> files;
  auto lost = fill(path, meshes, options, files);
  if (!lost) return lost;
  if (auto done = OutputFile::commitAll(files); !done) return done.error();
  return lost;
}

Result<Lines> writeEachTriangleMesh(std::span<const std::filesystem::path> paths,
                                    std::span<const NamedMesh> meshes,
                                    const MeshWriteOptions& options) {
  std::vector<OutputFile> files;
  Lines all;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const auto lost = fill(paths[i], meshes.subspan(i, 1), options, files);
    if (!lost) return lost;
    for (const std::string& line : *lost) {
      all.push_back(fmt::format("{}: {}", paths[i].string(), line));
    }
  }
  if (auto done = OutputFile::commitAll(files); !done) return done.error();
  return all;
}

}  // namespace t4d::formats
