#include "formats/gltf/gltf_reader.h"
#include "formats/gltf/gltf_writer.h"
#include "formats/triangle/obj_reader.h"
#include "formats/triangle/obj_writer.h"
#include "formats/triangle/off_reader.h"
#include "formats/triangle/off_writer.h"
#include "formats/triangle/ply_reader.h"
#include "formats/triangle/ply_writer.h"
#include "formats/triangle/stl_reader.h"
#include "formats/triangle/stl_writer.h"
#include "formats/triangle/triangle_mesh_formats.h"
#include "formats/usd/usd_writer.h"
#include "formats/vtk/vtk_surface_reader.h"
#include "formats/vtk/vtp_writer.h"

namespace t4d::formats {
std::span<const TriangleMeshFormat> triangleMeshFormats() {
  using Words = std::vector<std::string_view>;
  static const Words ofPly = {"double precision", "attributes"};
  static const Words ofVtp = {"double precision", "bodies", "names of bodies", "attributes",
                              "times"};
  static const Words ofObj = {"double precision", "bodies", "texture coordinates", "materials"};
  static const Words ofGltf = {"bodies", "names of bodies", "vertex attributes", "materials",
                               "units"};
  static const Words ofUsd = {"bodies", "names of bodies", "attributes", "units"};
  static const std::vector<TriangleMeshFormat> formats = {
      {".stl", "STL", readStl, writeStl},
      {".obj", "Wavefront OBJ", readObj, writeObj, false, ofObj},
      {".ply", "PLY", readPly, writePly, false, ofPly},
      {".off", "OFF", readOff, writeOff, false, {"double precision"}},
      {".vtp", "VTK polygonal data", readVtp, writeVtp, false, ofVtp},
      {".vtu", "VTK unstructured grid", readVtuSurface, nullptr, false, ofPly},
      {".gltf", "glTF", readGltf, writeGltfText, true, ofGltf},
      {".glb", "binary glTF", readGltf, writeGltfBinary, true, ofGltf},
      {".usda", "USD text", nullptr, writeUsdText, true, ofUsd},
      {".usdz", "USD package", nullptr, writeUsdPackage, true, ofUsd},
  };
  return formats;
}

}  // namespace t4d::formats
