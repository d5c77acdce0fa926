#include "t4d/formats/animation/foreign_scene.h"
#include "t4d/formats/gltf/gltf_reader.h"
#include "t4d/formats/gltf/gltf_writer.h"
#include "t4d/formats/triangle/obj_reader.h"
#include "t4d/formats/triangle/obj_writer.h"
#include "t4d/formats/triangle/off_reader.h"
#include "t4d/formats/triangle/off_writer.h"
#include "t4d/formats/triangle/ply_reader.h"
#include "t4d/formats/triangle/ply_writer.h"
#include "t4d/formats/triangle/stl_reader.h"
#include "t4d/formats/triangle/stl_writer.h"
#include "t4d/formats/triangle/triangle_mesh_formats.h"
#include "t4d/formats/usd/usd_reader.h"
#include "t4d/formats/usd/usd_writer.h"
#include "t4d/formats/vtk/vtk_surface_reader.h"
#include "t4d/formats/vtk/vtp_writer.h"

namespace t4d::formats {
namespace {

/// FBX and COLLADA, at rest.
Result<LoadedMesh> readForeignMesh(const InputFile& file, Keep keep) {
  auto scene = readForeignScene(file);
  if (!scene) return scene.error();
  auto mesh = readGltf(scene->glb, keep);
  if (!mesh) return mesh;
  mesh->notices.insert(mesh->notices.begin(), scene->notices.begin(), scene->notices.end());
  mesh->losses.insert(mesh->losses.begin(), scene->losses.begin(), scene->losses.end());
  return mesh;
}

}  // namespace

std::span<const TriangleMeshFormat> triangleMeshFormats() {
  using Words = std::vector<std::string_view>;
  static const Words ofPly = {"double precision", "attributes"};
  static const Words ofVtp = {"double precision", "bodies", "names of bodies", "attributes",
                              "times"};
  static const Words ofGltf = {"bodies", "names of bodies", "vertex attributes", "units"};
  static const Words ofUsd = {"bodies", "names of bodies", "attributes", "units"};
  static const Words ofForeign = {"units"};
  static const auto formats = [] {
    std::vector<TriangleMeshFormat> rows = {
        {".stl", "STL", readStl, writeStl},
        {".obj", "Wavefront OBJ", readObj, writeObj, false, {"double precision", "bodies"}},
        {".ply", "PLY", readPly, writePly, false, ofPly},
        {".off", "OFF", readOff, writeOff, false, {"double precision"}},
        {".vtp", "VTK polygonal data", readVtp, writeVtp, false, ofVtp},
        {".vtu", "VTK unstructured grid", readVtuSurface, nullptr, false, ofPly},
        {".gltf", "glTF", readGltf, writeGltfText, true, ofGltf},
        {".glb", "binary glTF", readGltf, writeGltfBinary, true, ofGltf},
        {".usda", "USD text", readUsd, writeUsdText, true, ofUsd},
        {".usdz", "USD package", readUsd, writeUsdPackage, true, ofUsd},
    };
    if (readsForeignScenes()) {
      rows.push_back({".fbx", "FBX", readForeignMesh, nullptr, false, ofForeign});
      rows.push_back({".dae", "COLLADA", readForeignMesh, nullptr, false, ofForeign});
    }
    return rows;
  }();
  return formats;
}

}  // namespace t4d::formats
