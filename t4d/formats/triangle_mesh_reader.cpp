#include "t4d/formats/triangle_mesh_reader.h"

#include <algorithm>
#include <array>
#include <new>

#include <fmt/format.h>

#include "t4d/formats/file_extension.h"
#include "t4d/formats/gltf_reader.h"
#include "t4d/formats/input_file.h"
#include "t4d/formats/obj_reader.h"
#include "t4d/formats/off_reader.h"
#include "t4d/formats/ply_reader.h"
#include "t4d/formats/stl_reader.h"

namespace t4d::formats {
namespace {

struct Reader {
  std::string_view extension;
  Result<LoadedMesh> (*read)(const InputFile&);
};

constexpr std::array<Reader, 6> kReaders{{{".stl", readStl},
                                          {".obj", readObj},
                                          {".ply", readPly},
                                          {".off", readOff},
                                          {".gltf", readGltf},
                                          {".glb", readGltf}}};

const Reader* readerFor(const std::filesystem::path& path) {
  const auto reader = std::ranges::find(kReaders, lowerCaseExtension(path), &Reader::extension);
  return reader == kReaders.end() ? nullptr : &*reader;
}

}  // namespace

bool canReadTriangleMesh(const std::filesystem::path& path) { return readerFor(path) != nullptr; }

Result<LoadedMesh> readTriangleMesh(const std::filesystem::path& path) {
  const auto file = readInputFile(path);
  if (!file) return pass(file.error());
  const Reader* reader = readerFor(path);
  if (reader == nullptr) {
    return fail(
        ErrorCode::Unsupported,
        fmt::format("the extension {} is not one of a triangle mesh: .stl, .obj, .ply, "
                    ".off, .gltf or .glb",
                    path.extension().string().empty() ? "(none)" : path.extension().string()),
        path.string(), Remedy::OtherFormat);
  }
  try {
    return reader->read(*file);
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::Failed, "the mesh does not fit in memory", path.string());
  }
}

}  // namespace t4d::formats
