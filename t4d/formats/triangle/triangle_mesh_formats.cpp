#include "t4d/formats/triangle/triangle_mesh_formats.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "t4d/formats/file_extension.h"
#include "t4d/formats/gltf/gltf_reader.h"
#include "t4d/formats/gltf/gltf_writer.h"
#include "t4d/formats/listed.h"
#include "t4d/formats/triangle/obj_reader.h"
#include "t4d/formats/triangle/obj_writer.h"
#include "t4d/formats/triangle/off_reader.h"
#include "t4d/formats/triangle/off_writer.h"
#include "t4d/formats/triangle/ply_reader.h"
#include "t4d/formats/triangle/ply_writer.h"
#include "t4d/formats/triangle/stl_reader.h"
#include "t4d/formats/triangle/stl_writer.h"
#include "t4d/formats/usd/usd_reader.h"
#include "t4d/formats/usd/usd_writer.h"
#include "t4d/formats/vtk/vtk_surface_reader.h"
#include "t4d/formats/vtk/vtp_writer.h"

namespace t4d::formats {
namespace {

constexpr std::array<std::string_view, 2> kObjKeeps = {"double precision", "bodies"};
constexpr std::array<std::string_view, 2> kPlyKeeps = {"double precision", "attributes"};
constexpr std::array<std::string_view, 1> kOffKeeps = {"double precision"};
constexpr std::array<std::string_view, 5> kVtpKeeps = {"double precision", "bodies",
                                                       "names of bodies", "attributes", "times"};
constexpr std::array<std::string_view, 2> kVtuKeeps = {"double precision", "attributes"};
constexpr std::array<std::string_view, 4> kGltfKeeps = {"bodies", "names of bodies",
                                                        "vertex attributes", "units"};
constexpr std::array<std::string_view, 4> kUsdKeeps = {"bodies", "names of bodies", "attributes",
                                                       "units"};

constexpr std::array kFormats{
    TriangleMeshFormat{".stl", "STL", readStl, writeStl},
    TriangleMeshFormat{".obj", "Wavefront OBJ", readObj, writeObj, false, kObjKeeps},
    TriangleMeshFormat{".ply", "PLY", readPly, writePly, false, kPlyKeeps},
    TriangleMeshFormat{".off", "OFF", readOff, writeOff, false, kOffKeeps},
    TriangleMeshFormat{".vtp", "VTK polygonal data", readVtp, writeVtp, false, kVtpKeeps},
    TriangleMeshFormat{".vtu", "VTK unstructured grid", readVtuSurface, nullptr, false, kVtuKeeps},
    TriangleMeshFormat{".gltf", "glTF", readGltf, writeGltfText, true, kGltfKeeps},
    TriangleMeshFormat{".glb", "binary glTF", readGltf, writeGltfBinary, true, kGltfKeeps},
    TriangleMeshFormat{".usda", "USD text", readUsd, writeUsdText, true, kUsdKeeps},
    TriangleMeshFormat{".usdz", "USD package", readUsd, writeUsdPackage, true, kUsdKeeps},
};

}  // namespace

std::span<const TriangleMeshFormat> triangleMeshFormats() { return kFormats; }

const TriangleMeshFormat* triangleMeshFormat(const std::filesystem::path& path) {
  const auto found =
      std::ranges::find(kFormats, lowerCaseExtension(path), &TriangleMeshFormat::extension);
  return found == kFormats.end() ? nullptr : &*found;
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
  if (lowerCaseExtension(path) == ".usdc" || lowerCaseExtension(path) == ".usd") {
    return fail(ErrorCode::Unsupported,
                "of USD, text is read; `usdcat --flatten IN.usdc -o OUT.usda` converts a file",
                path.string());
  }
  return fail(
      ErrorCode::Unsupported,
      fmt::format("{} is not the extension of a triangle mesh: {}",
                  extension.empty() ? "(none)" : extension, readableTriangleMeshExtensions()),
      path.string(), Remedy::OtherFormat);
}

std::string readableTriangleMeshExtensions() {
  std::vector<std::string_view> extensions;
  for (const auto& format : kFormats) {
    if (format.read != nullptr) extensions.push_back(format.extension);
  }
  return listed(extensions);
}

std::string writableTriangleMeshExtensions() {
  std::vector<std::string_view> extensions;
  for (const auto& format : kFormats) {
    if (format.write != nullptr) extensions.push_back(format.extension);
  }
  return listed(extensions);
}

}  // namespace t4d::formats
