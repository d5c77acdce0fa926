#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>

#include "t4d/fixtures/fields.h"
#include "t4d/fixtures/motions.h"
#include "t4d/formats/gltf_writer.h"
#include "t4d/formats/motion_reader.h"
#include "t4d/formats/t4d/writer.h"
#include "t4d/formats/triangle_mesh_writer.h"
#include "t4d/mesh4d/sweep.h"
#include "t4d/voxel4d/sampled_frames.h"
#include "t4d/voxel4d/vdb_samples.h"
#include "t4d/voxel4d/weave.h"

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
}

std::string contents(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void writeMeshSeeds(const fs::path& folder) {
  // The first byte of an input selects its format.
  for (const char* extension : {"stl", "obj", "ply"}) {
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
  write(folder / "colour_off", "fSTCNOFF 3 1\n0 0 0 1 2\n1 0 0 1 2\n0 1 0 1 2\n3 0 1 2\n");
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
  fill("mesh", t4d::fuzz::writeMeshSeeds);
  fill("gltf", t4d::fuzz::writeGltfSeeds);
  fill("vdb", t4d::fuzz::writeVdbSeeds);
}
