#include "formats/gltf/gltf_reader.h"

#include <limits>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "formats/gltf/meshopt_pack.h"
#include "formats/test_files.h"
#include "t4d/surface.h"

namespace t4d::formats {
namespace {

using nlohmann::json;

/// Two triangles of a unit square in a .glb: positions (48 bytes), then 16-bit indices (12 bytes).
json squareDocument() {
  return json::parse(R"({
    "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "buffers": [{"byteLength": 60}],
    "bufferViews": [{"buffer": 0, "byteLength": 48},
                    {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
    "accessors": [
      {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
      {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}]})");
}

std::string squareBuffer(std::vector<std::uint16_t> indices = {0, 1, 2, 2, 1, 3}) {
  std::string bytes;
  for (const float x : {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}) bytes += bytesOf(x);
  for (const std::uint16_t index : indices) bytes += bytesOf(index);
  return bytes;
}

std::string glb(const json& document, const std::string& buffer = squareBuffer()) {
  std::string text = document.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::string padded = buffer;
  padded.resize((padded.size() + 3) / 4 * 4);
  const auto size = [](std::size_t bytes) { return bytesOf(static_cast<std::uint32_t>(bytes)); };
  return "glTF" + size(2) + size(28 + text.size() + padded.size()) + size(text.size()) + "JSON" +
         text + size(padded.size()) + std::string("BIN\0", 4) + padded;
}

/// The document with a patch (RFC 6902) written as JSON.
json patched(const std::string& patch) { return squareDocument().patch(json::parse(patch)); }

std::string errorWith(const char* patch) { return errorOf("a.glb", glb(patched(patch))); }

double areaAlongZ(const model::TriangleMesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const auto& v = mesh.vertices;
    sum += (v[b] - v[a]).cross(v[c] - v[a]).z() / 2;
  }
  return sum;
}

double areaWith(const char* patch) {
  return areaAlongZ(readBytes("a.glb", glb(patched(patch))).mesh);
}

TEST(GltfReader, ReadsASquare) {
  const auto loaded = readBytes("a.glb", glb(squareDocument()));
  EXPECT_EQ(loaded.mesh.triangles, (std::vector<model::Triangle>{{0, 1, 2}, {2, 1, 3}}));
  EXPECT_EQ(areaAlongZ(loaded.mesh), 1);
}

TEST(GltfReader, ReadsABufferBesideTheFileAndNoneElsewhere) {
  auto document = squareDocument();
  document["buffers"][0]["uri"] = "square%20data.bin";
  writeFile("square data.bin", squareBuffer());
  EXPECT_EQ(readBytes("a.gltf", document.dump()).mesh.triangles.size(), 2u);
  document["buffers"][0]["uri"] = "../square.bin";
  EXPECT_EQ(errorOf("a.gltf", document.dump()),
            "a.gltf: buffers[0]: is at '../square.bin', expected the name of a file beside the "
            "glTF or in a folder below");
  document["buffers"][0]["uri"] = "https://example.com/square.bin";
  EXPECT_THAT(errorOf("a.gltf", document.dump()),
              testing::HasSubstr("expected the name of a file"));
  document["buffers"][0]["uri"] = "missing.bin";
  EXPECT_EQ(errorOf("a.gltf", document.dump()),
            "a.gltf: buffers[0]: needs the file 'missing.bin', which cannot be read: no such file");
  document["buffers"][0]["uri"] = "short.bin";
  writeFile("short.bin", squareBuffer().substr(1));
  EXPECT_EQ(errorOf("a.gltf", document.dump()),
            "a.gltf: buffers[0]: declares 60 bytes; 'short.bin' has 59");
  // A file may be longer than its buffer.
  document["buffers"][0]["uri"] = "long.bin";
  writeFile("long.bin", squareBuffer() + "more");
  EXPECT_EQ(readBytes("a.gltf", document.dump()).mesh.triangles.size(), 2u);
  // The file itself may be named in any way.
  document["buffers"][0]["uri"] = "square%20data.bin";
  const auto path = writeFile("a.gltf", document.dump());
  std::filesystem::create_directories(path.parent_path() / "a folder");
  EXPECT_TRUE(readTriangleMesh(path.parent_path() / "a folder" / ".." / "a.gltf"));
}

TEST(GltfReader, AppliesTheTransformsOfNodes) {
  EXPECT_EQ(areaWith(R"([{"op": "add", "path": "/nodes/0/scale", "value": [2, 3, 1]}])"), 6);
  EXPECT_NEAR(areaWith(R"([{"op": "add", "path": "/nodes/0/rotation", "value": [1, 0, 0, 0]}])"),
              -1, 1e-15);
  EXPECT_EQ(areaWith(R"([{"op": "add", "path": "/nodes/0/matrix",
                          "value": [0,2,0,0, -2,0,0,0, 0,0,2,0, 9,9,9,1]}])"),
            4);
  // Children stand in their parents: move by (1, 0, 0), then double.
  const auto child = readBytes("a.glb", glb(patched(R"([
        {"op": "add", "path": "/nodes/-", "value": {"children": [0], "scale": [2, 2, 2]}},
        {"op": "add", "path": "/nodes/0/translation", "value": [1, 0, 0]},
        {"op": "replace", "path": "/scenes/0/nodes", "value": [1]}])")));
  EXPECT_EQ(child.mesh.vertices[0], model::Point3(2, 0, 0));
}

TEST(GltfReader, SaysThatAMatrixShears) {
  const auto noticesOf = [](const std::string& matrix) {
    return readBytes("a.glb",
                     glb(patched(fmt::format(
                         R"([{{"op": "add", "path": "/nodes/0/matrix", "value": {}}}])", matrix))))
        .notices;
  };
  EXPECT_TRUE(noticesOf("[0,2,0,0, -2,0,0,0, 0,0,2,0, 9,9,9,1]").empty());
  for (const char* matrix :
       {"[1,0,0,0, 0.01,1,0,0, 0,0,1,0, 0,0,0,1]", "[1,0,0,0, 0,1,0,0, 0.01,0,1,0, 0,0,0,1]",
        "[1,0,0,0, 0,1,0,0, 0,0.01,1,0, 0,0,0,1]"}) {
    const auto notices = noticesOf(matrix);
    ASSERT_EQ(notices.size(), 1U) << matrix;
    EXPECT_NE(notices[0].find("shear the mesh"), std::string::npos);
  }
}

TEST(GltfReader, TurnsTrianglesOverWhereATransformMirrors) {
  EXPECT_EQ(areaWith(R"([{"op": "add", "path": "/nodes/0/scale", "value": [-1, 1, 1]}])"), 1);
}

TEST(GltfReader, ReadsStripsFansAndTrianglesWithoutIndices) {
  const char* kStrip = R"([{"op": "add", "path": "/meshes/0/primitives/0/mode", "value": 5},
                           {"op": "remove", "path": "/meshes/0/primitives/0/indices"}])";
  EXPECT_EQ(areaWith(kStrip), 1);
  auto fan = patched(R"([{"op": "add", "path": "/meshes/0/primitives/0/mode", "value": 6},
                         {"op": "replace", "path": "/accessors/1/count", "value": 4}])");
  const auto mesh = readBytes("a.glb", glb(fan, squareBuffer({0, 1, 3, 2, 0, 0}))).mesh;
  EXPECT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(areaAlongZ(mesh), 1);
}

TEST(GltfReader, ReadsNormalizedIntegersAndSparseValues) {
  // Bytes 48 to 52 of the buffer, as normalised 8-bit numbers: (1, 0.2, 0) for vertex 3.
  auto document = patched(R"([
    {"op": "add", "path": "/bufferViews/-", "value": {"buffer": 0, "byteLength": 32}},
    {"op": "replace", "path": "/accessors/0", "value":
      {"bufferView": 2, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC3"}},
    {"op": "add", "path": "/bufferViews/2/byteStride", "value": 4},
    {"op": "replace", "path": "/accessors/1/count", "value": 3}])");
  std::string buffer(60, '\0');
  buffer[4] = '\xff';
  buffer[9] = '\x33';
  buffer.replace(48, 6,
                 bytesOf<std::uint16_t>(0) + bytesOf<std::uint16_t>(1) + bytesOf<std::uint16_t>(2));
  EXPECT_EQ(readBytes("a.glb", glb(document, buffer)).mesh.vertices,
            (std::vector<model::Point3>{{0, 0, 0}, {1, 0, 0}, {0, 0.2, 0}}));

  auto sparse = patched(R"([{"op": "add", "path": "/accessors/0/sparse", "value":
    {"count": 1, "indices": {"bufferView": 1, "componentType": 5123, "byteOffset": 4},
     "values": {"bufferView": 0, "byteOffset": 36}}}])");
  // Element 2 takes the values of element 3.
  EXPECT_EQ(readBytes("a.glb", glb(sparse)).mesh.vertices.size(), 3u);
}

using Lines = std::vector<std::string>;

Lines lossesWith(const char* patch) { return readBytes("a.glb", glb(patched(patch))).losses; }

TEST(GltfReader, NotesHiddenNodes) {
  const auto loaded = readBytes("a.glb", glb(patched(R"([
    {"op": "add", "path": "/nodes/-", "value": {"mesh": 0, "scale": [0, 0, 0], "children": [2]}},
    {"op": "add", "path": "/nodes/-", "value": {"mesh": 0}},
    {"op": "add", "path": "/scenes/0/nodes/-", "value": 1}])")));
  EXPECT_EQ(loaded.mesh.triangles.size(), 2u);
  EXPECT_EQ(loaded.notices, Lines{"left out 1 hidden node: scale zero or not visible"});
  EXPECT_EQ(loaded.losses, Lines{});
}

TEST(GltfReader, LosesNothingOfPositionsAndTriangles) {
  EXPECT_EQ(readBytes("a.glb", glb(squareDocument())).losses, Lines{});
}

/// An animation of a node's translation; what its sampler names is not looked at.
std::string animationOf(int node) {
  return fmt::format(R"({{"op": "add", "path": "/animations", "value": [{{
    "channels": [{{"sampler": 0, "target": {{"node": {}, "path": "translation"}}}}],
    "samplers": [{{"input": 0, "output": 0}}]}}]}})",
                     node);
}

TEST(GltfReader, ListsTheAnimationOfNodesThatMoveAMeshAlone) {
  const char* kFamily = R"([{"op": "add", "path": "/nodes", "value":
    [{"mesh": 0}, {"children": [0, 2]}, {"name": "empty"}, {"name": "outside"}]},
    {"op": "replace", "path": "/scenes/0/nodes", "value": [1]}, )";
  const auto lossesOf = [&](int node) {
    return lossesWith((kFamily + animationOf(node) + "]").c_str());
  };
  const Lines moved{"the animation of 1 node: the mesh is as it is at rest"};
  EXPECT_EQ(lossesOf(0), moved);
  EXPECT_EQ(lossesOf(1), moved);
  EXPECT_EQ(lossesOf(2), Lines{});
  EXPECT_EQ(lossesOf(3), Lines{});
}

TEST(GltfReader, ListsAnAnimationThatShowsAHiddenNode) {
  EXPECT_EQ(lossesWith((R"([{"op": "add", "path": "/nodes/-", "value":
              {"mesh": 0, "scale": [0, 0, 0]}},
            {"op": "add", "path": "/scenes/0/nodes/-", "value": 1}, )" +
                        animationOf(1) + "]")
                           .c_str()),
            Lines{"the animation of 1 node: the mesh is as it is at rest"});
}

TEST(GltfReader, ListsSkinsAndMorphTargets) {
  EXPECT_EQ(lossesWith(R"([
              {"op": "add", "path": "/nodes/0/skin", "value": 0},
              {"op": "add", "path": "/skins", "value": [{"joints": [0]}]},
              {"op": "add", "path": "/meshes/0/primitives/0/attributes/JOINTS_0", "value": 0},
              {"op": "add", "path": "/meshes/0/primitives/0/attributes/WEIGHTS_0", "value": 0}])"),
            Lines{"the skin of 1 node: the mesh is as it is before skinning"});
  EXPECT_EQ(lossesWith(R"([{"op": "add", "path": "/meshes/0/primitives/0/targets",
                            "value": [{"POSITION": 0}]}])"),
            Lines{"the morph targets of 1 mesh: its base shape is used"});
}

/// The square as three instances: to x = 10; turned by 90 degrees about z and twice as large;
/// mirrored. The node moves all by z = 5.
json instancedDocument() {
  return patched(R"([
    {"op": "replace", "path": "/buffers/0/byteLength", "value": 144},
    {"op": "add", "path": "/nodes/0/translation", "value": [0, 0, 5]},
    {"op": "add", "path": "/bufferViews/-", "value": {"buffer": 0, "byteOffset": 60,
      "byteLength": 84}},
    {"op": "add", "path": "/accessors/-", "value":
      {"bufferView": 2, "componentType": 5126, "count": 3, "type": "VEC3"}},
    {"op": "add", "path": "/accessors/-", "value": {"bufferView": 2, "byteOffset": 36,
      "componentType": 5120, "normalized": true, "count": 3, "type": "VEC4"}},
    {"op": "add", "path": "/accessors/-", "value":
      {"bufferView": 2, "byteOffset": 48, "componentType": 5126, "count": 3, "type": "VEC3"}},
    {"op": "add", "path": "/nodes/0/extensions", "value": {"EXT_mesh_gpu_instancing":
      {"attributes": {"TRANSLATION": 2, "ROTATION": 3, "SCALE": 4}}}},
    {"op": "add", "path": "/extensionsUsed", "value": ["EXT_mesh_gpu_instancing"]},
    {"op": "add", "path": "/extensionsRequired", "value": ["EXT_mesh_gpu_instancing"]}])");
}

std::string instancedBuffer(float translation = 10, float scale = 1) {
  std::string bytes = squareBuffer();
  for (const float x : {translation, 0.F, 0.F, 0.F, 20.F, 0.F, 0.F, 0.F, 30.F}) {
    bytes += bytesOf(x);
  }
  for (const int x : {0, 0, 0, 127, 0, 0, 90, 90, 0, 0, 0, 127}) bytes += static_cast<char>(x);
  for (const float x : {scale, scale, scale, 2.F, 2.F, 2.F, -1.F, 1.F, 1.F}) bytes += bytesOf(x);
  return bytes;
}

TEST(GltfReader, PlacesEachInstanceBeforeTheNode) {
  const auto loaded = readBytes("a.glb", glb(instancedDocument(), instancedBuffer()));
  EXPECT_EQ(loaded.losses, Lines{});
  EXPECT_EQ(loaded.mesh.triangles.size(), 6U);
  EXPECT_NEAR(areaAlongZ(loaded.mesh), 1 + 4 + 1, 1e-12);
  const auto& v = loaded.mesh.vertices;
  ASSERT_EQ(v.size(), 12U);
  EXPECT_EQ(v[1], model::Point3(11, 0, 5));
  EXPECT_LT((v[5] - model::Point3(0, 22, 5)).norm(), 1e-14);
  EXPECT_EQ(v[9], model::Point3(-1, 0, 35));
}

TEST(GltfReader, NotesHiddenInstancesAndListsTheirOtherAttributes) {
  auto document = instancedDocument();
  document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["_ID"] = 2;
  const auto loaded = readBytes("a.glb", glb(document, instancedBuffer(10, 0)));
  EXPECT_EQ(loaded.mesh.triangles.size(), 4U);
  EXPECT_EQ(loaded.notices, Lines{"left out 1 hidden instance, whose scale is zero"});
  EXPECT_EQ(loaded.losses,
            Lines{"attribute _ID of instances: only positions and triangles are read"});
}

TEST(GltfReader, JudgesInstances) {
  const auto errorWhere = [](const char* patch, const std::string& buffer = instancedBuffer()) {
    return errorOf("a.glb", glb(instancedDocument().patch(json::parse(patch)), buffer));
  };
  EXPECT_EQ(errorWhere(R"([{"op": "replace", "path": "/accessors/4/count", "value": 2}])"),
            "a.glb: nodes[0].EXT_mesh_gpu_instancing: has 3 of ROTATION and 2 of SCALE; expected "
            "as many of each attribute");
  EXPECT_EQ(errorWhere(R"([{"op": "replace", "path": "/accessors/2/type", "value": "VEC2"}])"),
            "a.glb: accessors[2]: elements of 2 numbers, expected 3");
  EXPECT_EQ(errorWhere(R"([{"op": "remove", "path": "/accessors/3/normalized"}])"),
            "a.glb: accessors[3]: component type 5120; EXT_mesh_gpu_instancing has 5126 (float), "
            "or 5120 or 5122 (normalized) in rotations");
  EXPECT_EQ(
      errorWhere(R"([{"op": "replace", "path": "/accessors/2/componentType", "value": 5120}])"),
      "a.glb: accessors[2]: component type 5120; EXT_mesh_gpu_instancing has 5126 (float) in "
      "translations and scales");
  EXPECT_EQ(errorWhere("[]", instancedBuffer(std::numeric_limits<float>::infinity())),
            "a.glb: accessors[2]: element 0 has a number that is not finite");
  const char* attributes = "/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes";
  EXPECT_EQ(errorWhere(fmt::format(R"([{{"op": "remove", "path": "{}"}}])", attributes).c_str()),
            "a.glb: nodes[0].EXT_mesh_gpu_instancing: has no attributes");
  EXPECT_EQ(
      errorWhere(fmt::format(R"([{{"op": "replace", "path": "{}/SCALE", "value": 7}}])", attributes)
                     .c_str()),
      "a.glb: nodes[0].EXT_mesh_gpu_instancing: its attribute SCALE is not an accessor; there "
      "are 5");
  // Many times what the file holds: of those that are counted, and of one that nothing is read of.
  const auto many = [](std::uint64_t count, const char* only) {
    auto document = instancedDocument();
    for (const int i : {2, 3, 4}) document["accessors"][i]["count"] = count;
    auto& all = document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
    if (*only != 0) all = {{only, 2}};
    return errorOf("a.glb", glb(document, instancedBuffer()));
  };
  const std::string instantiated =
      "a.glb: meshes[0]: its nodes instantiate more geometry than the file holds; merge them into "
      "one mesh";
  EXPECT_EQ(many(4'000'000'000, ""), instantiated);
  EXPECT_EQ(many(std::uint64_t{1} << 62, ""), instantiated);
  EXPECT_EQ(many(1000, "_ID"),
            "a.glb: accessors[2]: 1000 elements of 12 bytes from byte 0, 12 bytes apart, but "
            "buffer view 2 has 84 bytes");
}

TEST(GltfReader, ListsGeometryThatItLeavesOut) {
  EXPECT_EQ(lossesWith(R"([
              {"op": "add", "path": "/meshes/0/primitives/-",
               "value": {"attributes": {"POSITION": 0}, "mode": 1}},
              {"op": "add", "path": "/meshes/-", "value": {"primitives": []}},
              {"op": "add", "path": "/scenes/-", "value": {}}])"),
            (Lines{"1 set of points or lines", "1 scene besides the default one",
                   "1 mesh outside the scene"}));
}

TEST(GltfReader, ListsWhatOnlyConcernsTheLookInOneLine) {
  EXPECT_EQ(lossesWith(R"([
              {"op": "add", "path": "/meshes/0/primitives/0/material", "value": 0},
              {"op": "add", "path": "/meshes/0/primitives/0/attributes/NORMAL", "value": 0},
              {"op": "add", "path": "/meshes/0/primitives/0/attributes/TEXCOORD_0", "value": 0},
              {"op": "add", "path": "/meshes/0/primitives/0/attributes/TEXCOORD_1", "value": 0},
              {"op": "add", "path": "/meshes/0/primitives/0/attributes/COLOR_0", "value": 0},
              {"op": "add", "path": "/meshes/0/primitives/0/attributes/_HEAT", "value": 0},
              {"op": "add", "path": "/materials", "value": [{}, {}]},
              {"op": "add", "path": "/images", "value": [{"uri": "a.png"}]},
              {"op": "add", "path": "/extensionsUsed",
               "value": ["KHR_materials_ior", "KHR_lights_punctual"]}])"),
            Lines{"vertex colors, normals, texture coordinates, attribute _HEAT, 1 material, "
                  "1 image, extension KHR_lights_punctual: only positions and triangles are read"});
}

TEST(GltfReader, KeepsColorsAndTextureCoordinates) {
  // The bytes of the positions again: the texture coordinates (0, 0), (0, 1), (0, 0), (0, 1).
  const std::string bytes = glb(patched(R"([
      {"op": "add", "path": "/accessors/-", "value":
        {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC2"}},
      {"op": "add", "path": "/meshes/0/primitives/0/attributes/COLOR_0", "value": 0},
      {"op": "add", "path": "/meshes/0/primitives/0/attributes/TEXCOORD_0", "value": 2},
      {"op": "add", "path": "/meshes/0/primitives/0/attributes/TEXCOORD_1", "value": 2}])"));
  const auto loaded = readBytes("a.glb", bytes, Keep::Attributes);
  ASSERT_EQ(loaded.mesh.attributes.size(), 2U);
  auto colors = model::makeAttribute("color", model::Domain::Vertex,
                                     std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0});
  colors.components = 3;
  EXPECT_EQ(loaded.mesh.attributes[0], colors);
  auto uv =
      model::makeAttribute("uv", model::Domain::Vertex, std::vector<float>{0, 1, 0, 0, 0, 1, 0, 0});
  uv.components = 2;
  EXPECT_EQ(loaded.mesh.attributes[1], uv);
  const auto shape = readBytes("a.glb", bytes);
  EXPECT_TRUE(shape.mesh.attributes.empty());
  EXPECT_EQ(shape.losses, std::vector<std::string>{"vertex colors, texture coordinates: only "
                                                   "positions and triangles are read"});
  EXPECT_EQ(loaded.losses,
            std::vector<std::string>{"further texture coordinates: only positions, triangles and "
                                     "COLOR_0, TEXCOORD_0 are read"});
}

TEST(GltfReader, KeepsTheNamesOfMaterials) {
  // The same triangles again, in another primitive: each is there twice.
  const std::string bytes = glb(patched(R"([
      {"op": "copy", "from": "/meshes/0/primitives/0", "path": "/meshes/0/primitives/-"},
      {"op": "add", "path": "/meshes/0/primitives/1/material", "value": 2},
      {"op": "add", "path": "/materials", "value": [{"name": "red"}, {"name": "red"}, {}]}])"));
  const auto loaded = readBytes("a.glb", bytes, Keep::Attributes);
  const std::size_t half = loaded.mesh.triangles.size() / 2;
  std::vector<std::uint32_t> numbers(half, 0);
  numbers.resize(2 * half, 1);
  ASSERT_EQ(loaded.mesh.attributes.size(), 1U);
  EXPECT_EQ(loaded.mesh.attributes[0],
            model::makeAttribute("material", model::Domain::Cell, numbers));
  EXPECT_EQ(loaded.materials, (std::vector<std::string>{"", "material 2"}));
  EXPECT_EQ(loaded.losses,
            Lines{"the look of 1 material: only positions, triangles and names of materials are "
                  "read"});
  const auto shape = readBytes("a.glb", bytes);
  EXPECT_TRUE(shape.mesh.attributes.empty() && shape.materials.empty());
}

TEST(GltfReader, ChecksEveryRange) {
  EXPECT_EQ(errorWith(R"([{"op": "replace", "path": "/accessors/0/count", "value": 5}])"),
            "a.glb: accessors[0]: 5 elements of 12 bytes from byte 0, 12 bytes apart, but buffer "
            "view 0 has 48 bytes");
  EXPECT_EQ(errorWith(R"([{"op": "replace", "path": "/accessors/0/count",
                           "value": 1537228672809129302}])"),
            "a.glb: accessors[0]: 1537228672809129302 elements of 12 bytes from byte 0, 12 bytes "
            "apart, but buffer view 0 has 48 bytes");
  EXPECT_EQ(errorWith(R"([{"op": "replace", "path": "/bufferViews/0/byteLength", "value": 61}])"),
            "a.glb: accessors[0]: buffer view 0 is 61 bytes from byte 0, but its buffer has 60");
  EXPECT_EQ(errorWith(R"([{"op": "replace", "path": "/bufferViews/0/buffer", "value": 1}])"),
            "a.glb: accessors[0]: buffer view 0 refers to buffer 1, but there are 1");
  EXPECT_EQ(errorWith(R"([{"op": "replace", "path": "/accessors/0/bufferView", "value": 7}])"),
            "a.glb: accessors[0]: refers to buffer view 7, but there are 2");
  EXPECT_EQ(errorWith(R"([{"op": "remove", "path": "/accessors/0/bufferView"},
                          {"op": "replace", "path": "/accessors/0/count", "value": 4000000000}])"),
            "a.glb: accessors[0]: 4000000000 elements without a buffer view");
  EXPECT_EQ(errorWith(R"([{"op": "replace", "path": "/accessors/0/type", "value": "VEC2"}])"),
            "a.glb: accessors[0]: elements of 2 numbers, expected 3");
  EXPECT_EQ(
      errorWith(R"([{"op": "replace", "path": "/accessors/0/componentType", "value": 5130}])"),
      "a.glb: accessors[0]: component type 5130, which glTF 2.0 does not have");
  EXPECT_EQ(errorWith(R"([{"op": "replace", "path": "/meshes/0/primitives/0/attributes/POSITION",
                           "value": 9}])"),
            "a.glb: accessors[9]: does not exist; there are 2");
  EXPECT_EQ(errorWith(R"([{"op": "replace", "path": "/nodes/0/mesh", "value": 3}])"),
            "a.glb: meshes[3]: does not exist; there are 1");
  EXPECT_EQ(errorWith(R"([{"op": "replace", "path": "/scenes/0/nodes", "value": [4]}])"),
            "a.glb: nodes[4]: does not exist; there are 1");
  EXPECT_EQ(errorWith(R"([{"op": "replace", "path": "/scene", "value": 1}])"),
            "a.glb: scenes[1]: does not exist; there are 1");
  EXPECT_EQ(errorWith(R"([{"op": "add", "path": "/nodes/0/children", "value": [0]}])"),
            "a.glb: nodes[0]: has two parents or is its own ancestor");
  EXPECT_EQ(errorOf("a.glb", glb(squareDocument(), squareBuffer({0, 1, 2, 2, 1, 4}))),
            "a.glb: accessors[1]: index 5 is 4, but a.glb: meshes[0].primitives[0] has 4 "
            "positions");
}

TEST(GltfReader, RefusesWhatItCannotRead) {
  // An extension that is needed is named, whatever else the file would be refused for.
  EXPECT_EQ(errorWith(R"([{"op": "add", "path": "/extensionsRequired", "value": ["EXT_new"]},
                          {"op": "remove", "path": "/buffers/0/byteLength"}])"),
            "a.glb: requires the extension EXT_new, which is not supported");
  const char* draco = R"({"op": "add", "path": "/meshes/0/primitives/0/extensions",
                          "value": {"KHR_draco_mesh_compression": {"bufferView": 0}}})";
  EXPECT_EQ(
      errorWith(fmt::format(R"([{}, {{"op": "remove", "path": "/accessors/0/bufferView"}}])", draco)
                    .c_str()),
      "a.glb: meshes[0].primitives[0]: is compressed by KHR_draco_mesh_compression and cannot be "
      "unpacked: its extension lacks bufferView or attributes");
  // It has the same mesh plain.
  EXPECT_EQ(areaWith(fmt::format("[{}]", draco).c_str()), 1);
  EXPECT_EQ(errorWith(R"([{"op": "replace", "path": "/asset/version", "value": "1.0"}])"),
            "a.glb: is glTF version '1.0', expected 2.0");
  const std::string deep(100'000, '[');
  EXPECT_EQ(errorOf("a.gltf", R"({"extras":)" + deep),
            "a.gltf: has JSON nested more than 200 levels deep");
  EXPECT_EQ(errorOf("a.gltf", "{\"scene\": 0}"),
            "a.gltf: is not glTF 2.0: \"asset\" object not found in .gltf or not an object type");
  EXPECT_EQ(errorOf("a.gltf", R"({"asset": {"version": "2.0"}, "scene": 1e999})"),
            "a.gltf: is not glTF 2.0: its JSON has a number overflow parsing '1e999'");
  auto bytes = glb(squareDocument());
  EXPECT_EQ(errorOf("a.glb", bytes.substr(0, bytes.size() - 1)),
            fmt::format("a.glb: byte 8: declares a length of {} bytes; the file has {}",
                        bytes.size(), bytes.size() - 1));
  bytes.replace(4, 4, bytesOf(1));
  EXPECT_EQ(errorOf("a.glb", bytes), "a.glb: byte 4: is version 1 of binary glTF, expected 2");
}

/// The square, with one of its buffer views (0: positions, 1: indices) compressed, and no bytes
/// of it as they are.
std::string compressedSquare(std::size_t number, const std::string& extension,
                             const std::string& packed, json view) {
  auto document = squareDocument();
  const std::string plain = squareBuffer();
  view.update({{"buffer", 0}, {"byteOffset", 60}, {"byteLength", packed.size()}});
  document["bufferViews"][number]["extensions"][extension] = view;
  document["bufferViews"][number]["buffer"] = 1;
  document["buffers"][0]["byteLength"] = 60 + packed.size();
  document["buffers"].push_back(
      {{"byteLength", 60}, {"extensions", {{extension, {{"fallback", true}}}}}});
  document["extensionsRequired"] = {extension};
  return glb(document,
             std::string(60, '\0').replace(number == 0 ? 48 : 0, number == 0 ? 12 : 48, plain,
                                           number == 0 ? 48 : 0, number == 0 ? 12 : 48) +
                 packed);
}

std::string packedBytes(std::string_view bytes, std::size_t elementBytes, bool isTriangles) {
  const auto packed =
      meshoptPacked({reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()},
                    elementBytes, isTriangles);
  return packed ? std::string(packed->begin(), packed->end()) : std::string();
}

TEST(GltfReader, UnpacksWhatMeshoptimizerCompressed) {
  if (!hasMeshopt()) GTEST_SKIP() << "no meshoptimizer";
  const std::string plain = squareBuffer();
  const json positions = {{"mode", "ATTRIBUTES"}, {"byteStride", 12}, {"count", 4}};
  const json indices = {{"mode", "TRIANGLES"}, {"byteStride", 2}, {"count", 6}};
  const std::string packedPositions = packedBytes(plain.substr(0, 48), 12, false);
  const std::string packedIndices = packedBytes(plain.substr(48), 2, true);
  for (const char* extension : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
    for (const auto& file : {compressedSquare(0, extension, packedPositions, positions),
                             compressedSquare(1, extension, packedIndices, indices)}) {
      const auto loaded = readBytes("a.glb", file);
      EXPECT_EQ(areaAlongZ(loaded.mesh), 1);
      EXPECT_EQ(loaded.mesh.triangles.size(), 2U);
      EXPECT_TRUE(loaded.losses.empty());
    }
  }
}

TEST(GltfReader, UnpacksFiltersOfMeshoptimizer) {
  if (!hasMeshopt()) GTEST_SKIP() << "no meshoptimizer";
  // 2^E * M: E in the upper 8 bits, M in the lower 24. The square is four times as large.
  std::string numbers;
  for (const int x : {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}) {
    numbers += bytesOf(std::uint32_t{1U << 24U | static_cast<unsigned>(x)});
  }
  const auto loaded = readBytes(
      "a.glb",
      compressedSquare(
          0, "EXT_meshopt_compression", packedBytes(numbers, 12, false),
          {{"mode", "ATTRIBUTES"}, {"byteStride", 12}, {"count", 4}, {"filter", "EXPONENTIAL"}}));
  EXPECT_EQ(areaAlongZ(loaded.mesh), 4);
}

TEST(GltfReader, SaysWhyItCannotUnpack) {
  if (!hasMeshopt()) GTEST_SKIP() << "no meshoptimizer";
  const std::string packed = packedBytes(squareBuffer().substr(0, 48), 12, false);
  const auto problem = [&](const std::string& bytes, const json& changes) {
    json view = {{"mode", "ATTRIBUTES"}, {"byteStride", 12}, {"count", 4}};
    view.update(changes);
    const std::string text =
        errorOf("a.glb", compressedSquare(0, "EXT_meshopt_compression", bytes, view));
    const std::string begin =
        "a.glb: accessors[0]: buffer view 0 is compressed by EXT_meshopt_compression and cannot be "
        "unpacked: ";
    EXPECT_EQ(text.substr(0, begin.size()), begin);
    return text.substr(std::min(text.size(), begin.size()));
  };
  EXPECT_EQ(problem(packed, {{"mode", "NEW"}}),
            "4 elements of 12 bytes with mode NEW and filter NONE are not supported");
  EXPECT_EQ(problem(packed, {{"filter", "QUATERNION"}}),
            "4 elements of 12 bytes with mode ATTRIBUTES and filter QUATERNION are not supported");
  EXPECT_EQ(problem(packed, {{"count", 1'000'000'000'000}}),
            fmt::format("{} bytes cannot hold 1000000000000 elements of 12 bytes", packed.size()));
  for (std::size_t size = 0; size < packed.size(); ++size) {
    EXPECT_THAT(problem(packed.substr(0, size), json::object()),
                testing::AnyOf(testing::HasSubstr("bytes are damaged"),
                               testing::HasSubstr("bytes cannot hold")));
  }
  for (std::size_t i = 0; i < packed.size(); ++i) {
    std::string damaged = packed;
    damaged[i] = static_cast<char>(~damaged[i]);
    const auto path = writeFile(
        "a.glb", compressedSquare(0, "EXT_meshopt_compression", damaged,
                                  {{"mode", "ATTRIBUTES"}, {"byteStride", 12}, {"count", 4}}));
    const auto loaded = readTriangleMesh(path);  // read as other numbers, or refused
    EXPECT_TRUE(loaded || loaded.error().where.file == path.string());
  }
}

TEST(GltfReader, RefusesGeometryThatAFewBytesMultiply) {
  auto document = squareDocument();
  const std::size_t points = 1'000'000;
  document["buffers"][0]["byteLength"] = 12 * points;
  document["bufferViews"][0]["byteLength"] = 12 * points;
  document["accessors"][0]["count"] = points;
  const auto primitive = document["meshes"][0]["primitives"][0];
  for (int i = 0; i < 1000; ++i) document["meshes"][0]["primitives"].push_back(primitive);
  EXPECT_EQ(errorOf("a.glb", glb(document, std::string(12 * points, '\0'))),
            "a.glb: meshes[0]: its nodes instantiate more geometry than the file "
            "holds; merge them into one mesh");
  // Two meshes, either of which would be read alone.
  auto& primitives = document["meshes"][0]["primitives"];
  primitives = std::vector<json>(15, primitive);
  document["meshes"].push_back(document["meshes"][0]);
  document["nodes"].push_back({{"mesh", 1}});
  document["scenes"][0]["nodes"] = {0, 1};
  EXPECT_EQ(errorOf("a.glb", glb(document, std::string(12 * points, '\0'))),
            "a.glb: meshes[1]: its nodes instantiate more geometry than the file "
            "holds; merge them into one mesh");
}

}  // namespace
}  // namespace t4d::formats
