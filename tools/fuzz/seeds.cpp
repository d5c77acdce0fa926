#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>

#include <fmt/format.h>

#include "fixtures/deformations.h"
#include "fixtures/fields.h"
#include "fixtures/mechanisms.h"
#include "fixtures/milled_programs.h"
#include "fixtures/motions.h"
#include "fixtures/tool_paths.h"
#include "formats/gltf/gltf_writer.h"
#include "formats/mesh4d/mesh4d_formats.h"
#include "t4d/file.h"
#include "t4d/frames.h"
#include "t4d/motion.h"
#include "t4d/surface.h"
#include "t4d/sweep.h"
#include "t4d/weave.h"
#include "voxel4d/frame_formats.h"
#include "voxel4d/sampled_frames.h"
#include "voxel4d/vdb_samples.h"
#include "voxel4d/volumes/volume_samples.h"

/// Writes the seeds of the fuzzers, one folder each: `fuzz_seeds FOLDER`. Together they use every
/// feature of their formats, in files as small as possible, which a fuzzer executes faster.
namespace t4d::fuzz {
namespace {

namespace fs = std::filesystem;
using formats::T4dWriteOptions;

template <class T>
T expect(Result<T> result) {
  if (result) {
    if constexpr (std::is_void_v<T>) {
      return;
    } else {
      return std::move(*result);
    }
  }
  std::cerr << "fuzz_seeds: " << result.error().text() << "\n";
  std::exit(1);
}

void write(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

model::TriangleMesh tetrahedron() {
  model::TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

/// Adds a vertex attribute and a cell attribute to the slabs that it passes on.
class WithAttributes : public model::Sink {
 public:
  explicit WithAttributes(model::Sink& next) : next_(next) {}
  Result<void> put(const model::Slab& slab) override {
    model::Slab more = slab;
    std::vector<float> warmth;
    for (const model::Point4& vertex : slab.vertices) {
      warmth.push_back(static_cast<float>(vertex[3]));
    }
    more.attributes.push_back(makeAttribute("warmth", model::Domain::Vertex, warmth));
    setMeans(*slab.connectivity, more.attributes.back());
    const std::vector<std::uint8_t> zone(slab.connectivity->cells.size(), 7);
    more.attributes.push_back(makeAttribute("zone", model::Domain::Cell, zone));
    return next_.put(more);
  }

 private:
  model::Sink& next_;
};

using Producer = std::function<void(model::Sink&)>;

void sweepTetrahedron(model::Sink& sink) {
  const auto motion = expect(formats::parseMotion(
      R"({"segments":[{"duration":1,"axis_direction":[0,0,1],"angle_degrees":30,"repeat":2}]})",
      "seed"));
  mesh4d::SweepOptions options;
  options.steps = mesh4d::StepsPerSegment{1};
  options.caps = mesh4d::CapMethod::Cone;
  expect(mesh4d::sweep(tetrahedron(), motion, options, sink));
}

void weaveSphere(model::Sink& sink) {
  const fixtures::Field field = fixtures::translatingSphere(0.8, {0.5, 0, 0});
  const auto frames = voxel4d::sampledFrames(field.value, {}, field.box, {0, 1});
  expect(voxel4d::weave(*frames, {}, sink));
}

void putSimplex(model::Sink& sink) {
  auto connectivity = std::make_shared<model::Connectivity>();
  connectivity->vertexCount = 5;
  connectivity->cells = {{1, 2, 3, 4}, {2, 0, 3, 4}, {0, 1, 3, 4}, {1, 0, 2, 4}, {0, 1, 2, 3}};
  model::Slab slab;
  slab.timeEnd = 1;
  slab.vertices = {{0, 0, 0, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
  slab.connectivity = connectivity;
  expect(sink.put(slab));
}

void writeT4d(const fs::path& path, const std::vector<Producer>& producers,
              const T4dWriteOptions& options) {
  formats::Metadata metadata;
  metadata.generator = "seed";
  metadata.lengthUnit = "mm";
  for (std::size_t i = 0; i < producers.size(); ++i) metadata.bodies.push_back({std::to_string(i)});
  auto writer = expect(formats::T4dWriter::create(path, metadata, options));
  for (std::size_t i = 0; i < producers.size(); ++i) producers[i](writer.body(i));
  expect(writer.finish());
}

void writeT4dSeeds(const fs::path& folder) {
  const auto swept = [](model::Sink& sink) { sweepTetrahedron(sink); };
  const auto attributed = [](model::Sink& sink) {
    WithAttributes with(sink);
    sweepTetrahedron(with);
  };
  writeT4d(folder / "simplex.t4d", {putSimplex}, {.compression = 0});
  writeT4d(folder / "two_simplices.t4d", {putSimplex, putSimplex}, {.compression = 0});
  writeT4d(folder / "swept.t4d", {swept}, {});
  writeT4d(folder / "swept_raw.t4d", {swept}, {.compression = 0, .float32 = true, .index = false});
  writeT4d(folder / "attributes.t4d", {attributed, putSimplex}, {.compression = 1});
  writeT4d(folder / "attributes_raw.t4d", {attributed}, {.compression = 0});
  writeT4d(folder / "woven.t4d", {weaveSphere}, {.float32 = true});
}

void writeMotionSeeds(const fs::path& folder) {
  for (const auto& motion : fixtures::allMotions()) {
    write(folder / (motion.name + ".json"), motion.json);
  }
  write(folder / "poses.csv",
        "# c\ntime,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n1,1,0,0,0,0,0.6,0.8\n");
  write(folder / "matrix.csv",
        "t;m00;m01;m02;m03;m10;m11;m12;m13;m20;m21;m22;m23\n"
        "0;1;0;0;0;0;1;0;0;0;0;1;0\n1;0;-1;0;2;1;0;0;0;0;0;1;0\n");
}

void writeMechanismSeeds(const fs::path& folder) {
  std::string table;
  for (const auto& file : fixtures::mechanismFiles()) {
    if (file.name == "arm-joints.csv") table = file.text;
  }
  for (const auto& file : fixtures::mechanismFiles()) {
    const bool urdf = file.text.starts_with('<');
    write(folder / file.name, urdf ? file.text + '\0' + table : file.text);
  }
  write(folder / "slider.urdf",
        std::string("<robot name='r'><link name='a'><visual><geometry><sphere radius='1'/>"
                    "</geometry></visual></link><link name='b'><collision><origin rpy='0 0 1'/>"
                    "<geometry><cylinder radius='1' length='2'/></geometry></collision></link>"
                    "<link name='c'/><joint name='j' type='prismatic'><parent link='a'/>"
                    "<child link='b'/><axis xyz='1 0 0'/><limit lower='0' upper='1'/></joint>"
                    "<joint name='k' type='continuous'><parent link='b'/><child link='c'/>"
                    "<mimic joint='j' multiplier='2'/></joint></robot>") +
            '\0' +
            "%time,field.name0,field.position0\n1700000000000000000,j,0\n"
            "1700000001000000000,j,1\n");
}

std::string contents(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void writeToolPathSeeds(const fs::path& folder) {
  for (const auto& path : fixtures::toolPathFiles()) write(folder / path.name, path.text);
  for (const auto& program : fixtures::postedPrograms())
    write(folder / (program.name + ".nc"), program.text);
  for (const auto& program : fixtures::milledPrograms()) {
    write(folder / (program.name + ".nc"), program.text);
    write(folder / (program.name + "-5.nc"), "#1=0\n" + program.text);
  }
  write(folder / "arcs.nc",
        "G20 G0 X1 Y0 Z0\nG18 G3 X0 Z1 I-1 K0 F9\nG91 G19 G2 Y1 Z1 R1.5\nG90.1 G17 G2 X0 Y0 I0 "
        "J1\nG4 P1\n");
  write(folder / "inches.cl",
        "UNITS/INCHES\nFROM/0,0,0\nRAPID\nGOTO/1,0, $\n0,1,0,0\nFEDRAT/IPM,3\nGOTO/2,0,0\n");
}

void writeCacheSeeds(const fs::path& folder) {
  const std::vector<fixtures::NamedSolid> solids(2, {"a", "", tetrahedron()});
  write(folder / "pc2", "p" + fixtures::pointCacheText(solids));
  write(folder / "mdd",
        "m" + std::string("\0\0\0\2\0\0\0\1\0\0\0\0\x3f\x80\0\0", 16) + std::string(24, '\0'));
}

void writeMeshSeeds(const fs::path& folder) {
  // The first byte of an input selects its format.
  for (const char* extension : {"stl", "obj", "ply", "vtp"}) {
    const fs::path path = folder / extension;
    const fs::path named = path.string() + "." + extension;
    expect(formats::writeTriangleMeshes(named, std::vector{formats::NamedMesh{"a", tetrahedron()}},
                                        {.attributes = true}));
    const std::string bytes = contents(named);
    fs::remove(named);
    write(path, extension[0] + bytes);
  }
  write(folder / "text_stl",
        "ssolid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
        "endloop\nendfacet\nendsolid a\n");
  write(
      folder / "text_obj",
      "o# c\nv 0 0 0\nv 1 0 0 1\nv 0.2 0.2 0\nv 0 1 0\nv -1 -1e1 0\nf 1/1 2//2 \\\n -2/1/1 4 5\n");
  write(folder / "text_ply",
        "pply\nformat ascii 1.0\ncomment c\nelement vertex 5\nproperty float x\nproperty float y\n"
        "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n0.2 0.2 0\n0 1 0\n-1 -1 0\n5 0 1 2 3 4\n");
  write(folder / "big_endian_ply",
        std::string("pply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty short x\n"
                    "property short y\nproperty short z\nproperty uchar red\nelement face 1\n"
                    "property list uchar ushort vertex_index\nend_header\n") +
            std::string("\0\0\0\0\0\0\1\0\1\0\0\0\0\1\0\0\0\1\0\0\1\3\0\0\0\1\0\2", 28));
  write(folder / "off",
        "fOFF\n# c\n4 2 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n4 0 1 3 2\n3 0 1 2 1.0 0 0\n");
  const std::string points =
      "<Points><DataArray type=\"Float32\" NumberOfComponents=\"3\">0 0 0 1 0 0 0 1 0 0 0 1"
      "</DataArray></Points>";
  const auto cells = [](const std::string& corners, const std::string& ends) {
    return "<DataArray type=\"Int32\" Name=\"connectivity\">" + corners +
           "</DataArray><DataArray type=\"Int32\" Name=\"offsets\">" + ends + "</DataArray>";
  };
  write(folder / "text_vtp",
        "v<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"4\" NumberOfPolys=\"1\" "
        "NumberOfStrips=\"1\" NumberOfLines=\"0\"><CellData><DataArray type=\"UInt8\" "
        "Name=\"vtkGhostType\">0 0</DataArray></CellData>" +
            points + "<Polys>" + cells("0 1 2", "3") + "</Polys><Strips>" + cells("0 1 2 3", "4") +
            "</Strips></Piece></PolyData></VTKFile>");
  write(folder / "text_vtu",
        "u<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"4\" "
        "NumberOfCells=\"2\"><PointData><DataArray type=\"Float64\" Name=\"h\">0 1 2 3"
        "</DataArray></PointData>" +
            points + "<Cells>" + cells("0 1 2 3 0 1 2", "4 7") +
            "<DataArray type=\"UInt8\" Name=\"types\">10 5</DataArray></Cells></Piece>"
            "</UnstructuredGrid></VTKFile>");
  write(folder / "colour_off", "fSTCNOFF 3 1\n0 0 0 1 2\n1 0 0 1 2\n0 1 0 1 2\n3 0 1 2\n");
}

/// Two 4-simplices in each format of 4D meshes.
void writeMesh4dSeeds(const fs::path& folder) {
  model::Mesh simplex;
  putSimplex(simplex);
  const std::vector<formats::CountedBody> bodies = {{{"a", &simplex}, 5, 5},
                                                    {{"b", &simplex}, 5, 5}};
  const auto mesh = expect(formats::FlatBodies::of(bodies));
  char number = 0;
  for (const formats::Mesh4dFormat& format : formats::mesh4dFormats()) {
    const fs::path path = folder / format.id;
    std::string bytes;
    for (const std::string_view extension : format.extensions) {
      fs::path named = path;
      named += extension;
      if (bytes.empty()) expect(format.write(named, mesh));
      bytes += (bytes.empty() ? std::string(1, number) : std::string(1, '\0')) + contents(named);
      fs::remove(named);
    }
    write(path, bytes);
    ++number;
  }
}

void writeGltfSeeds(const fs::path& folder) {
  const std::vector meshes = {formats::NamedMesh{"a", tetrahedron()}};
  expect(formats::writeTriangleMeshes(folder / "a.glb", meshes,
                                      {.placement = {.metresPerUnit = 0.5, .zUp = true}}));
  expect(formats::writeTriangleMeshes(folder / "a.gltf", meshes));
  auto flipbook = expect(formats::FlipbookWriter::create(folder / "flipbook.glb", 10));
  expect(flipbook.add(0, meshes));
  expect(flipbook.add(1, meshes));
  expect(flipbook.finish());
  // A skin, a morph target and curves of every kind; the numbers are zero.
  write(folder / "animated.gltf",
        R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0,"skin":0,"children":[1]},{"mesh":0}],)"
        R"("meshes":[{"primitives":[{"attributes":{"POSITION":1,"JOINTS_0":2,"WEIGHTS_0":3},)"
        R"("targets":[{"POSITION":1}]}]}],"skins":[{"joints":[0,1],"inverseBindMatrices":4}],)"
        R"("animations":[{"samplers":[{"input":0,"output":1},{"input":0,"output":5,)"
        R"("interpolation":"STEP"},{"input":0,"output":6,"interpolation":"CUBICSPLINE"}],)"
        R"("channels":[{"sampler":0,"target":{"node":1,"path":"translation"}},{"sampler":1,)"
        R"("target":{"node":0,"path":"rotation"}},{"sampler":2,"target":{"node":1,)"
        R"("path":"weights"}}]}],"accessors":[{"bufferView":0,"componentType":5126,"count":2,)"
        R"("type":"SCALAR"},{"bufferView":0,"componentType":5126,"count":2,"type":"VEC3"},)"
        R"({"bufferView":0,"byteOffset":8,"componentType":5121,"count":3,"type":"VEC4"},)"
        R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC4"},{"bufferView":0,)"
        R"("componentType":5126,"count":2,"type":"MAT4"},{"bufferView":0,"componentType":5126,)"
        R"("count":2,"type":"VEC4"},{"bufferView":0,"componentType":5126,"count":6,)"
        R"("type":"SCALAR"}],"bufferViews":[{"buffer":0,"byteLength":24}],)"
        R"("buffers":[{"byteLength":24,"uri":"data:application/octet-stream;base64,)"
        R"(AAAAAAAAgD8AAIA/AAAAAAAAAAAAAAAA"}]})");
  // Integers, a strip and a fan, sparse values, matrices, a node of two parents, an extension.
  write(folder / "parts.gltf",
        R"({"asset":{"version":"2.0"},"extensionsUsed":["KHR_mesh_quantization"],)"
        R"("extensionsRequired":["KHR_mesh_quantization"],"scene":0,"scenes":[{"nodes":[0]}],)"
        R"("nodes":[{"children":[1,2]},{"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,5,6,7,1]},)"
        R"({"mesh":1,"rotation":[0,0,1,0],"scale":[1,2,3],"translation":[1,2,3]}],)"
        R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"mode":5}]},)"
        R"({"primitives":[{"attributes":{"POSITION":2},"mode":6}]}],)"
        R"("accessors":[{"bufferView":0,"componentType":5122,"normalized":true,"count":4,)"
        R"("type":"VEC3"},{"bufferView":1,"componentType":5121,"count":4,"type":"SCALAR"},)"
        R"({"componentType":5126,"count":3,"type":"VEC3","sparse":{"count":2,"indices":)"
        R"({"bufferView":1,"componentType":5121},"values":{"bufferView":2}}}],)"
        R"("bufferViews":[{"buffer":0,"byteLength":32,"byteStride":8},)"
        R"({"buffer":0,"byteOffset":32,"byteLength":4},)"
        R"({"buffer":0,"byteOffset":36,"byteLength":24}],)"
        R"("buffers":[{"byteLength":60,"uri":"data:application/octet-stream;base64,)"
        R"(AAAAAAAAAAABAAAAAAAAAAAAAQAAAAAAAAAAAAEAAAAAAQIDAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})");
}

void writeVdbSeeds(const fs::path& folder) {
  for (const auto& [name, bytes] : voxel4d::vdbSamples()) write(folder / (name + ".vdb"), bytes);
}

/// The first byte is that of the extension.
void writeVolumeSeeds(const fs::path& folder) {
  const auto extensions = voxel4d::volumeExtensions();
  for (const auto& [name, bytes] : voxel4d::volumeSamples()) {
    for (std::size_t i = 0; i < extensions.size(); ++i) {
      if (!name.ends_with(extensions[i])) continue;
      write(folder / name, static_cast<char>(i) + bytes);
    }
  }
}

}  // namespace
}  // namespace t4d::fuzz

int main(int count, char** arguments) {
  if (count != 2) {
    std::cerr << "Usage: fuzz_seeds FOLDER\n";
    return 2;
  }
  const std::filesystem::path root = arguments[1];
  const auto fill = [&](const char* name, void (*seeds)(const std::filesystem::path&)) {
    std::filesystem::remove_all(root / name);
    std::filesystem::create_directories(root / name);
    seeds(root / name);
  };
  fill("t4d", t4d::fuzz::writeT4dSeeds);
  fill("motion", t4d::fuzz::writeMotionSeeds);
  fill("mechanism", t4d::fuzz::writeMechanismSeeds);
  fill("tool_path", t4d::fuzz::writeToolPathSeeds);
  fill("cache", t4d::fuzz::writeCacheSeeds);
  fill("mesh", t4d::fuzz::writeMeshSeeds);
  fill("mesh4d", t4d::fuzz::writeMesh4dSeeds);
  fill("gltf", t4d::fuzz::writeGltfSeeds);
  fill("vdb", t4d::fuzz::writeVdbSeeds);
  fill("volume", t4d::fuzz::writeVolumeSeeds);
}
