#include "t4d/formats/triangle_mesh_writer.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "t4d/formats/file_extension.h"
#include "t4d/formats/obj_writer.h"
#include "t4d/formats/output_file.h"
#include "t4d/formats/ply_writer.h"
#include "t4d/formats/stl_writer.h"
#include "t4d/formats/written_mesh.h"

namespace t4d::formats {
namespace {

struct Writer {
  std::string_view extension;
  Result<std::vector<std::string>> (*write)(OutputFile&, std::span<const NamedMesh>,
                                            const MeshWriteOptions&);
};

constexpr std::array<Writer, 3> kWriters{
    {{".stl", writeStl}, {".obj", writeObj}, {".ply", writePly}}};

const Writer* writerFor(const std::filesystem::path& path) {
  const auto found = std::ranges::find(kWriters, lowerCaseExtension(path), &Writer::extension);
  return found == kWriters.end() ? nullptr : &*found;
}

}  // namespace

bool canWriteTriangleMesh(const std::filesystem::path& path) { return writerFor(path) != nullptr; }

std::string writableTriangleMeshExtensions() {
  std::string all;
  for (const Writer& writer : kWriters) {
    if (!all.empty()) all += ", ";
    all += writer.extension;
  }
  return all;
}

Result<std::vector<std::string>> writeTriangleMeshes(const std::filesystem::path& path,
                                                     std::span<const NamedMesh> meshes,
                                                     const MeshWriteOptions& options) {
  const auto atPath = [&](Error error) {
    error.where = error.where.empty() ? path.string() : path.string() + ": " + error.where;
    return pass(std::move(error));
  };
  const Writer* writer = writerFor(path);
  if (writer == nullptr) {
    return fail(
        ErrorCode::Unsupported,
        fmt::format("a triangle mesh can be written to {}", writableTriangleMeshExtensions()),
        path.string());
  }
  for (const NamedMesh& named : meshes) {
    if (auto good = checkWritable(named); !good) return atPath(good.error());
  }
  auto file = OutputFile::create(path);
  if (!file) return pass(file.error());
  auto lost = writer->write(*file, meshes, options);
  if (!lost)
    return lost.error().code == ErrorCode::Failed ? pass(lost.error()) : atPath(lost.error());
  if (auto done = file->commit(); !done) return pass(done.error());
  return lost;
}

}  // namespace t4d::formats
