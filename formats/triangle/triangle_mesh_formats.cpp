#include "formats/triangle/triangle_mesh_formats.h"

#include <algorithm>

#include <fmt/format.h>

#include "formats/file_extension.h"
#include "formats/listed.h"

namespace t4d::formats {

const TriangleMeshFormat* triangleMeshFormat(const std::filesystem::path& path) {
  const auto formats = triangleMeshFormats();
  const auto found =
      std::ranges::find(formats, lowerCaseExtension(path), &TriangleMeshFormat::extension);
  return found == formats.end() ? nullptr : &*found;
}

Result<void> checkMeshExtension(const std::filesystem::path& path) {
  const TriangleMeshFormat* format = triangleMeshFormat(path);
  if (format != nullptr && format->read != nullptr) return {};
  if (format != nullptr) {
    return fail(ErrorCode::Unsupported,
                fmt::format("{} ({}) is written, not read; triangle meshes are read from {}",
                            format->extension, format->name, readableTriangleMeshExtensions()),
                path.string());
  }
  const std::string extension = path.extension().string();
  return fail(
      ErrorCode::Unsupported,
      fmt::format("{} is not the extension of a triangle mesh: {}",
                  extension.empty() ? "(none)" : extension, readableTriangleMeshExtensions()),
      path.string(), Remedy::OtherFormat);
}

std::string readableTriangleMeshExtensions() {
  std::vector<std::string_view> extensions;
  for (const auto& format : triangleMeshFormats()) {
    if (format.read != nullptr) extensions.push_back(format.extension);
  }
  return listed(extensions);
}

std::vector<std::string_view> writableTriangleMeshes() {
  std::vector<std::string_view> extensions;
  for (const auto& format : triangleMeshFormats()) {
    if (format.write != nullptr) extensions.push_back(format.extension);
  }
  return extensions;
}

std::string writableTriangleMeshExtensions() { return listed(writableTriangleMeshes()); }

}  // namespace t4d::formats
