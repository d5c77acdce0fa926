#include "formats/gltf/gltf_writer.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/gltf/gltf_animation.h"
#include "formats/gltf/gltf_builder.h"
#include "formats/input_file.h"
#include "formats/test_files.h"

namespace t4d::formats {
namespace {

NamedMesh box(double width, double height = 1, const std::string& name = "box") {
  NamedMesh named{name, {}};
  for (int i = 0; i < 8; ++i) {
    named.mesh.vertices.push_back(cubeCorner(i).cwiseProduct(model::Point3(width, 1, height)));
  }
  for (const auto& s : kCubeSquares) {
    for (const auto& [b, c] : {std::pair{1, 2}, std::pair{2, 3}}) {
      named.mesh.triangles.push_back({static_cast<std::uint32_t>(s[0]),
                                      static_cast<std::uint32_t>(s[b]),
                                      static_cast<std::uint32_t>(s[c])});
    }
  }
  return named;
}

nlohmann::json documentOf(const std::filesystem::path& path) {
  const std::string bytes = platform::contents(path);
  if (path.extension() == ".gltf") return nlohmann::json::parse(bytes);
  return nlohmann::json::parse(bytes.substr(20, loadNumber<std::uint32_t>(bytes.data() + 12)));
}

/// The numbers of a float32 accessor of a .glb file.
std::vector<float> floatsOf(const std::filesystem::path& path, int index) {
  const std::string bytes = platform::contents(path);
  const auto document = documentOf(path);
  const auto& accessor = document["accessors"][static_cast<std::size_t>(index)];
  const auto& view = document["bufferViews"][accessor["bufferView"].get<std::size_t>()];
  const std::size_t begin =
      28 + loadNumber<std::uint32_t>(bytes.data() + 12) + view.value("byteOffset", 0u);
  std::vector<float> numbers;
  for (std::size_t i = 0; i < view["byteLength"]; i += 4) {
    numbers.push_back(loadNumber<float>(bytes.data() + begin + i));
  }
  return numbers;
}

TEST(GltfWriter, WritesWhatTheReaderReads) {
  const auto named = box(0.1);
  for (const char* file : {"a.glb", "a.gltf"}) {
    const auto path = temporaryPath(file);
    const auto lost =
        writeTriangleMeshes(path, std::vector{named, box(3, 1, "other"), {"empty", {}}});
    ASSERT_TRUE(lost) << lost.error().text();
    EXPECT_TRUE(lost->empty());
    const auto loaded = readTriangleMesh(path);
    ASSERT_TRUE(loaded) << loaded.error().text();
    EXPECT_NEAR(model::signedVolume(loaded->mesh), 3.1, 1e-8);
    EXPECT_EQ(documentOf(path)["meshes"].size(), 2u);
    EXPECT_EQ(loaded->mesh.vertices[1], model::Point3(0.1F, 0, 0));
  }
}

TEST(GltfWriter, WhatIsCompressedIsReadAsIfItWereNot) {
  if (!hasMeshopt()) GTEST_SKIP() << "no meshoptimizer";
  NamedMesh fine = box(2);
  // Large enough that the compression is worth its header.
  for (int i = 0; i < 200; ++i) {
    const NamedMesh more = box(1 + 0.25 * i, 1 + 0.125 * i);
    const auto first = static_cast<std::uint32_t>(fine.mesh.vertices.size());
    for (const auto& p : more.mesh.vertices) fine.mesh.vertices.push_back(p);
    for (const auto& [a, b, c] : more.mesh.triangles) {
      fine.mesh.triangles.push_back({first + a, first + b, first + c});
    }
  }
  for (const char* name : {"plain.glb", "plain.gltf"}) {
    const auto plain = temporaryPath(name);
    ASSERT_TRUE(writeTriangleMeshes(plain, std::vector{fine}));
    const auto packed = temporaryPath("packed").replace_extension(plain.extension());
    MeshWriteOptions options;
    options.gltf.meshopt = true;
    ASSERT_TRUE(writeTriangleMeshes(packed, std::vector{fine}, options));
    EXPECT_LT(std::filesystem::file_size(packed), std::filesystem::file_size(plain));
    EXPECT_EQ(documentOf(packed)["extensionsRequired"][0], "EXT_meshopt_compression");
    const auto expected = readTriangleMesh(plain);
    const auto loaded = readTriangleMesh(packed);
    ASSERT_TRUE(loaded) << loaded.error().text();
    EXPECT_EQ(loaded->mesh.vertices, expected->mesh.vertices);
    EXPECT_EQ(model::signedVolume(loaded->mesh), model::signedVolume(expected->mesh));
    EXPECT_TRUE(loaded->losses.empty());
  }
}

TEST(GltfWriter, RepeatsVerticesWhoseCornersDiffer) {
  NamedMesh named = box(2);
  std::vector<float> numbers;
  for (std::size_t i = 0; i < 3 * named.mesh.triangles.size(); ++i) {
    numbers.insert(numbers.end(), {static_cast<float>(i) / 64, 0.25F});
  }
  model::Attribute uv = model::makeAttribute("uv:corners", model::Domain::Cell, numbers);
  uv.components = 6;
  named.mesh.attributes = {uv};
  const auto path = temporaryPath("seams.glb");
  // They are not those of these triangles, unless that is said.
  const auto lost = writeTriangleMeshes(path, std::vector{named}, {.attributes = true});
  ASSERT_TRUE(lost) << lost.error().text();
  EXPECT_EQ(lost->size(), 1U);
  named.ownCorners = true;
  const auto none = writeTriangleMeshes(path, std::vector{named}, {.attributes = true});
  ASSERT_TRUE(none) << none.error().text();
  EXPECT_TRUE(none->empty());
  const auto loaded = readTriangleMesh(path, Keep::Attributes);
  ASSERT_TRUE(loaded) << loaded.error().text();
  EXPECT_EQ(loaded->mesh.triangles, named.mesh.triangles);
  EXPECT_EQ(loaded->mesh.attributes, std::vector{uv});
  EXPECT_TRUE(loaded->losses.empty());
}

/// The name of the material of each triangle, by the sum of its corners.
std::map<std::array<double, 3>, std::string> materialsByPlace(
    const model::TriangleMesh& mesh, const std::vector<std::string>& names) {
  std::map<std::array<double, 3>, std::string> materials;
  const auto found = std::ranges::find(mesh.attributes, "material", &model::Attribute::name);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    std::uint32_t number = 0;
    if (found != mesh.attributes.end()) std::memcpy(&number, found->row(i), sizeof number);
    model::Point3 sum(0, 0, 0);
    for (const std::uint32_t corner : mesh.triangles[i]) sum += mesh.vertices[corner];
    materials[{sum.x(), sum.y(), sum.z()}] = names.empty() ? "" : names[number];
  }
  return materials;
}

TEST(GltfWriter, WritesAPrimitiveForEachMaterialOfTriangles) {
  NamedMesh named = box(2);
  named.mesh.attributes = {
      model::makeAttribute("material", model::Domain::Cell,
                           std::vector<std::uint32_t>{2, 2, 0, 0, 1, 1, 1, 3, 3, 0, 0, 2})};
  MeshWriteOptions options{.attributes = true, .materials = {"", "wood", "steel", "glass"}};
  const auto expected = materialsByPlace(named.mesh, options.materials);
  for (const char* file : {"m.glb", "m.gltf", "m.obj"}) {
    const auto path = temporaryPath(file);
    const auto lost = writeTriangleMeshes(path, std::vector{named}, options);
    ASSERT_TRUE(lost) << lost.error().text();
    EXPECT_TRUE(lost->empty()) << file;
    const auto loaded = readTriangleMesh(path, Keep::Attributes);
    ASSERT_TRUE(loaded) << loaded.error().text();
    EXPECT_EQ(materialsByPlace(loaded->mesh, loaded->materials), expected) << file;
    EXPECT_TRUE(loaded->losses.empty()) << file;
    if (path.extension() == ".obj") continue;
    EXPECT_EQ(documentOf(path)["meshes"][0]["primitives"].size(), 4U);
  }
  // Without names, or without attributes, there is one primitive.
  for (const auto& other : {MeshWriteOptions{.attributes = true}, MeshWriteOptions{}}) {
    const auto path = temporaryPath("one.glb");
    const auto lost = writeTriangleMeshes(path, std::vector{named}, other);
    EXPECT_EQ(lost->size(), other.attributes ? 1U : 0U);
    EXPECT_EQ(documentOf(path)["meshes"][0]["primitives"].size(), 1U);
    EXPECT_TRUE(readTriangleMesh(path, Keep::Attributes)->materials.empty());
  }
}

TEST(GltfWriter, PlacesInMetresWithYUp) {
  const auto path = temporaryPath("placed.glb");
  ASSERT_TRUE(writeTriangleMeshes(path, std::vector{box(2, 5)},
                                  {.placement = {0.001, true, R"({"lengthUnit": "mm"})"}}));
  const auto loaded = readTriangleMesh(path);
  ASSERT_TRUE(loaded) << loaded.error().text();
  const auto bounds = model::boundsOf(loaded->mesh);
  EXPECT_TRUE(bounds.min.isApprox(model::Point3(0, 0, -0.001), 1e-12)) << bounds.min;
  EXPECT_TRUE(bounds.max.isApprox(model::Point3(0.002, 0.005, 0), 1e-12)) << bounds.max;
  EXPECT_NEAR(model::signedVolume(loaded->mesh), 10e-9, 1e-18);
  const auto root = documentOf(path)["nodes"][0];
  EXPECT_EQ(
      root["extras"],
      (nlohmann::json{{"metresPerUnit", 0.001}, {"upAxisOfSource", "z"}, {"lengthUnit", "mm"}}));
}

TEST(GltfWriter, WritesVertexAttributesAndListsTheOthers) {
  auto named = box(1);
  using model::Domain;
  named.mesh.attributes = {
      model::makeAttribute<double>("heat flux", Domain::Vertex, {1, 2, 3, 4, 5, 6, 7, 8}),
      model::makeAttribute<float>("bad", Domain::Vertex, {1, 2, 3, 4, 5, 6, 7, NAN}),
      model::makeAttribute<std::uint8_t>("kind", Domain::Cell,
                                         {0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1})};
  const auto path = temporaryPath("attributes.glb");
  const auto lost = writeTriangleMeshes(path, std::vector{named}, {.attributes = true});
  ASSERT_TRUE(lost) << lost.error().text();
  EXPECT_EQ(*lost, (std::vector<std::string>{
                       "vertex attribute 'bad': some of its numbers are not finite in float32, the "
                       "only type that fits all",
                       "triangle attribute 'kind': glTF has attributes of vertices only"}));
  const auto attributes = documentOf(path)["meshes"][0]["primitives"][0]["attributes"];
  EXPECT_EQ(attributes.size(), 2u);
  EXPECT_EQ(floatsOf(path, attributes["_HEAT_FLUX"]), (std::vector<float>{1, 2, 3, 4, 5, 6, 7, 8}));
}

TEST(GltfWriter, TakesWideIndicesOnlyWhereTheyAreNeeded) {
  for (const std::uint32_t count : {65535u, 65536u}) {
    NamedMesh named{"fan", {}};
    for (std::uint32_t i = 0; i < count; ++i) named.mesh.vertices.emplace_back(i, i % 7, 1);
    for (std::uint32_t i = 2; i < count; ++i) named.mesh.triangles.push_back({0, i - 1, i});
    const auto path = temporaryPath("wide.glb");
    ASSERT_TRUE(writeTriangleMeshes(path, std::vector{named}));
    EXPECT_EQ(documentOf(path)["accessors"][1]["componentType"], count == 65535 ? 5123 : 5125);
    EXPECT_EQ(readTriangleMesh(path)->mesh.triangles, named.mesh.triangles);
  }
}

TEST(GltfWriter, WritesAValidSceneOfNothing) {
  for (const char* file : {"nothing.glb", "nothing.gltf"}) {
    const auto path = temporaryPath(file);
    ASSERT_TRUE(writeTriangleMeshes(path, {}));
    EXPECT_FALSE(documentOf(path).contains("nodes"));
    EXPECT_EQ(readTriangleMesh(path).error().message, "holds no triangles");
  }
}

TEST(GltfWriter, RefusesWhatCannotBeWritten) {
  const auto path = temporaryPath("refused.glb");
  auto named = box(1e39);
  EXPECT_EQ(writeTriangleMeshes(path, std::vector{named}).error().where.text(),
            path.string() + ": mesh 'box'");
  EXPECT_EQ(writeTriangleMeshes(path, {}, {.placement = {0}}).error().message,
            "0 metres for a unit of length, expected more than 0");
  EXPECT_EQ(writeTriangleMeshes(path, {}, {.placement = {1, false, "[1]"}}).error().message,
            "the extras are not a JSON object");
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(GltfWriter, KeepsNamesAsFarAsTheyAreUtf8) {
  const auto path = temporaryPath("names.glb");
  const auto lost = writeTriangleMeshes(
      path, std::vector{box(1, 1, "caf\xe9"), box(2, 1, "caf\xc3\xa9"), box(3, 1, "a/b")});
  ASSERT_TRUE(lost) << lost.error().text();
  ASSERT_EQ(lost->size(), 1U);
  EXPECT_NE(lost->front().find("that are not UTF-8"), std::string::npos);
  std::vector<std::string> names;
  const auto document = documentOf(path);
  for (const auto& mesh : document["meshes"]) names.push_back(mesh["name"]);
  EXPECT_EQ(names, (std::vector<std::string>{"caf_", "caf\xc3\xa9", "a/b"}));
}

TEST(GltfWriter, StopsBeforeAFileGrowsBeyondItsLimit) {
  const auto path = temporaryPath("large.glb");
  const auto meshesThatFit = [&](std::uint64_t bytes) -> Result<int> {
    MeshWriteOptions options;
    options.gltf.maxBytes = bytes;
    auto builder = GltfBuilder::create(GltfBuilder::Form::Binary, options);
    for (int i = 0; i < 3; ++i) {
      if (auto mesh = builder->addMesh(box(1)); !mesh) return mesh;
    }
    auto file = OutputFile::create(path);
    auto lost = builder->finish(*file);
    if (!lost) return lost.error();
    EXPECT_TRUE(file->commit());
    return static_cast<int>(std::filesystem::file_size(path));
  };
  const auto size = meshesThatFit(1'000'000);
  ASSERT_TRUE(size);
  const auto exact = static_cast<std::uint64_t>(*size);
  EXPECT_TRUE(meshesThatFit(exact));
  for (const std::uint64_t limit : {exact - 1, std::uint64_t{400}}) {
    const auto refused = meshesThatFit(limit);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().message,
              "more than the 4 GiB that a .glb can have; write fewer frames or meshes");
  }
}

/// The scale of a node at a time, from a file's animation.
double scaleAt(const std::filesystem::path& path, int node, double time) {
  const auto animation = documentOf(path)["animations"][0];
  for (const auto& channel : animation["channels"]) {
    if (channel["target"]["node"] != node) continue;
    const auto& sampler = animation["samplers"][channel["sampler"].get<std::size_t>()];
    EXPECT_EQ(sampler["interpolation"], "STEP");
    const auto times = floatsOf(path, sampler["input"]);
    const auto scales = floatsOf(path, sampler["output"]);
    EXPECT_EQ(scales.size(), 3 * times.size());
    EXPECT_EQ(times.front(), 0);
    std::size_t key = 0;
    while (key + 1 < times.size() && times[key + 1] <= time) ++key;
    return scales[3 * key];
  }
  return -1;
}

TEST(GltfWriter, QuantizesWithinHalfAStep) {
  for (const int bits : {1, 8, 12, 16}) {
    NamedMesh named = box(3, 0.7);
    std::uint32_t seed = 1;
    for (model::Point3& vertex : named.mesh.vertices) {
      for (double& coordinate : vertex) {
        seed = seed * 1664525 + 1013904223;
        coordinate += 1000 + seed / 4294967296.0 / 8;
      }
    }
    MeshWriteOptions options;
    options.origin = {5, 6, 7};
    const Quantization grid{bits, boundsOf(named.mesh)};
    options.gltf.quantization = grid;
    const auto path = temporaryPath("quantized.glb");
    ASSERT_TRUE(writeTriangleMeshes(path, {&named, 1}, options));
    EXPECT_EQ(documentOf(path)["extensionsRequired"][0], "KHR_mesh_quantization");
    const auto file = readInputFile(path);
    const auto view = documentOf(path)["bufferViews"][0];
    const std::size_t begin = 28 + loadNumber<std::uint32_t>(file->bytes.data() + 12);
    const auto root = documentOf(path)["nodes"][0];
    ASSERT_EQ(view["byteStride"], 8);
    for (std::size_t i = 0; i < named.mesh.vertices.size(); ++i) {
      for (int k = 0; k < 3; ++k) {
        const auto steps =
            loadNumber<std::uint16_t>(file->bytes.data() + begin + 8 * i + 2 * std::size_t(k));
        EXPECT_LT(steps, 1 << bits);
        const double found = root["translation"][k].get<double>() - options.origin[k] +
                             steps * root["scale"][k].get<double>();
        EXPECT_NEAR(found, named.mesh.vertices[i][k], grid.step() / 2 * (1 + 1e-9));
      }
    }
    options.gltf.quantization->bounds.max.x() -= 2;
    EXPECT_NE(
        writeTriangleMeshes(path, {&named, 1}, options).error().message.find("outside the bounds"),
        std::string::npos);
  }
}

TEST(GltfWriter, RepeatsVerticesWhereTrianglesOfSeveralColorsMeet) {
  NamedMesh named = box(1);
  named.colors = MeshColors{model::Domain::Cell, {}};
  for (int i = 0; i < 12; ++i) named.colors->colors.push_back({i < 6 ? 1.0F : 0.0F, 0, 0.5F, 1});
  const auto path = temporaryPath("colors.glb");
  ASSERT_TRUE(writeTriangleMeshes(path, {&named, 1}));
  const auto document = documentOf(path);
  const auto primitive = document["meshes"][0]["primitives"][0];
  const auto colors = document["accessors"][primitive["attributes"]["COLOR_0"].get<std::size_t>()];
  EXPECT_EQ(colors["normalized"], true);
  EXPECT_EQ(colors["componentType"], 5123);
  // Half of the squares of the box have each colour: some corners have both.
  EXPECT_GT(colors["count"], 8);
  EXPECT_LT(colors["count"], 17);
  EXPECT_NEAR(model::signedVolume(readTriangleMesh(path)->mesh), 1, 1e-6);
  named.colors->colors.pop_back();
  EXPECT_EQ(writeTriangleMeshes(path, {&named, 1}).error().message, "11 colours for 12 triangles");
}

TEST(FlipbookWriter, BeginsAnotherFileBeforeOneGrowsBeyondItsLimit) {
  for (const char* extension : {".glb", ".gltf"}) {
    const auto path = temporaryPath(std::string("split") + extension);
    MeshWriteOptions options;
    options.gltf.maxBytes = 30'000;
    auto writer = FlipbookWriter::create(path, 10, options);
    constexpr int kFrames = 23;
    for (int i = 0; i < kFrames; ++i) {
      ASSERT_TRUE(writer->add(i, std::vector{box(1 + i)}));
    }
    const auto lost = writer->finish();
    ASSERT_TRUE(lost) << lost.error().text();
    EXPECT_GT(writer->files().size(), 2U);
    EXPECT_FALSE(std::filesystem::exists(path));
    double next = 0;
    for (std::size_t i = 0; i < writer->files().size(); ++i) {
      const auto& file = writer->files()[i];
      EXPECT_EQ(file.filename().string(), fmt::format("split-{}{}", i + 1, extension));
      if (path.extension() == ".glb") {
        EXPECT_LE(std::filesystem::file_size(file), 30'000U);
      }
      const auto document = documentOf(file);
      for (std::size_t node = 1; node < document["nodes"].size(); ++node) {
        EXPECT_EQ(document["nodes"][node]["extras"]["time"], next);
        EXPECT_EQ(document["nodes"][node].contains("scale"), node > 1);
        ++next;
      }
    }
    EXPECT_EQ(next, kFrames);
  }
}

TEST(FlipbookWriter, ShowsFramesByTheirVisibility) {
  const auto path = temporaryPath("visibility.glb");
  MeshWriteOptions options;
  options.gltf.visibility = true;
  auto writer = FlipbookWriter::create(path, 2, options);
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(writer->add(i, std::vector{box(1 + i)}));
  ASSERT_TRUE(writer->finish());
  const auto document = documentOf(path);
  EXPECT_EQ(document["extensionsUsed"],
            nlohmann::json::parse(R"(["KHR_animation_pointer", "KHR_node_visibility"])"));
  EXPECT_EQ(document["extensionsRequired"], document["extensionsUsed"]);
  const auto bytes = readInputFile(path)->bytes;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& node = document["nodes"][i + 1];
    EXPECT_FALSE(node.contains("scale"));
    EXPECT_EQ(node["extensions"]["KHR_node_visibility"]["visible"], i == 0);
    const auto& channel = document["animations"][0]["channels"][i];
    EXPECT_FALSE(channel["target"].contains("node"));
    EXPECT_EQ(channel["target"]["path"], "pointer");
    EXPECT_EQ(channel["target"]["extensions"]["KHR_animation_pointer"]["pointer"],
              fmt::format("/nodes/{}/extensions/KHR_node_visibility/visible", i + 1));
    const auto& sampler = document["animations"][0]["samplers"][i];
    const auto times = floatsOf(path, sampler["input"]);
    const auto& output = document["accessors"][sampler["output"].get<std::size_t>()];
    EXPECT_EQ(output["componentType"], 5121);
    EXPECT_EQ(output["count"], times.size());
    const auto& view = document["bufferViews"][output["bufferView"].get<std::size_t>()];
    const std::size_t begin =
        28 + loadNumber<std::uint32_t>(bytes.data() + 12) + view["byteOffset"].get<std::size_t>();
    for (std::size_t key = 0; key < times.size(); ++key) {
      const bool shown = times[key] >= 0.5F * static_cast<float>(i) &&
                         (times[key] < 0.5F * static_cast<float>(i + 1) || i == 2);
      EXPECT_EQ(bytes[begin + key], shown ? 1 : 0);
    }
  }
}

TEST(FlipbookWriter, ShowsExactlyOneFrameAtAnyTime) {
  for (const int frames : {1, 2, 3, 7}) {
    const auto path = temporaryPath("flipbook.glb");
    auto writer = FlipbookWriter::create(path, 25);
    ASSERT_TRUE(writer) << writer.error().text();
    for (int i = 0; i < frames; ++i) {
      ASSERT_TRUE(writer->add(100.5 + i, std::vector{box(1 + i)}));
    }
    const auto lost = writer->finish();
    ASSERT_TRUE(lost) << lost.error().text();
    const auto document = documentOf(path);
    ASSERT_EQ(document["nodes"].size(), static_cast<std::size_t>(frames) + 1);
    for (int i = 0; i < frames; ++i) {
      const auto& node = document["nodes"][static_cast<std::size_t>(i) + 1];
      EXPECT_EQ(node["extras"]["time"], 100.5 + i);
      EXPECT_EQ(node.contains("scale"), i > 0);
      for (int at = 0; at < frames; ++at) {
        EXPECT_EQ(scaleAt(path, i + 1, (at + 0.5) / 25), at == i) << i << " of " << frames;
      }
    }
    const auto input = document["animations"][0]["samplers"].back()["input"];
    EXPECT_FLOAT_EQ(floatsOf(path, input).back(), static_cast<float>(frames) / 25);
  }
}

TEST(FlipbookWriter, RestsAtTheFirstFrame) {
  const auto path = temporaryPath("rest.glb");
  auto writer = FlipbookWriter::create(path, 10);
  ASSERT_TRUE(writer->add(0, std::vector{box(2), box(3, 1, "other")}));
  ASSERT_TRUE(writer->add(1, std::vector{box(5), box(7, 1, "other")}));
  ASSERT_TRUE(writer->finish());
  const auto loaded = readTriangleMesh(path);
  ASSERT_TRUE(loaded) << loaded.error().text();
  EXPECT_EQ(model::signedVolume(loaded->mesh), 5);
  EXPECT_EQ(loaded->notices,
            std::vector<std::string>{"left out 1 hidden node: scale zero or not visible"});
  EXPECT_EQ(loaded->losses,
            std::vector<std::string>{"the animation of 2 nodes: the mesh is as it is at rest"});
}

TEST(FlipbookWriter, IsReadAsTheFramesThatItShows) {
  for (const bool visibility : {false, true}) {
    const auto path = temporaryPath("shown.glb");
    MeshWriteOptions options;
    options.gltf.visibility = visibility;
    auto writer = FlipbookWriter::create(path, 2, options);
    for (const int width : {2, 3, 5}) ASSERT_TRUE(writer->add(width, std::vector{box(width)}));
    ASSERT_TRUE(writer->finish());
    const auto scene = readGltfAnimation(*readInputFile(path), {});
    ASSERT_TRUE(scene) << scene.error().text();
    EXPECT_TRUE(scene->losses.empty());
    ASSERT_EQ(scene->bodies.size(), 3U);
    for (std::size_t frame = 0; frame < 3; ++frame) {
      const AnimatedBody& body = scene->bodies[frame];
      ASSERT_EQ(body.runs.size(), 1U);
      const auto& run = *body.runs.front();
      EXPECT_EQ(run.time(0), 0.5 * static_cast<double>(frame));
      EXPECT_EQ(run.time(run.count() - 1), 0.5 * static_cast<double>(frame + 1));
    }
    const auto rest = readTriangleMesh(path);
    ASSERT_TRUE(rest) << rest.error().text();
    EXPECT_EQ(model::signedVolume(rest->mesh), 2);
  }
}

TEST(FlipbookWriter, HasNoNodeForAnEmptyFrame) {
  const auto path = temporaryPath("gap.glb");
  auto writer = FlipbookWriter::create(path, 10);
  for (const auto& meshes :
       {std::vector<NamedMesh>{{"box", {}}}, std::vector{box(1)}, std::vector<NamedMesh>{},
        std::vector{box(2), NamedMesh{"b", {}}}, std::vector<NamedMesh>{{"box", {}}}}) {
    ASSERT_TRUE(writer->add(0, meshes));
  }
  ASSERT_TRUE(writer->finish());
  EXPECT_EQ(documentOf(path)["animations"][0]["channels"].size(), 2u);
  for (int at = 0; at < 5; ++at) {
    EXPECT_EQ(scaleAt(path, 1, 0.1 * (at + 0.5)), at == 1);
    EXPECT_EQ(scaleAt(path, 2, 0.1 * (at + 0.5)), at == 3);
  }
}

TEST(FlipbookWriter, RefusesWhatMakesNoFlipbook) {
  const auto path = temporaryPath("none.glb");
  EXPECT_EQ(FlipbookWriter::create(path, 0).error().message,
            "0 frames a second, expected more than 0");
  EXPECT_EQ(FlipbookWriter::create("a.stl", 1).error().text(),
            "a.stl: unsupported output extension; a flipbook is written as .glb or .gltf");
  EXPECT_FALSE(FlipbookWriter::create(temporaryPath("missing") / "a.glb", 1));
  auto writer = FlipbookWriter::create(path, 1e30);
  EXPECT_EQ(writer->finish().error().message, "a flipbook without frames");
  EXPECT_FALSE(writer->add(NAN, {}));
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(writer->add(i, std::vector{box(1)}));
  EXPECT_TRUE(writer->finish());  // times of 1e-30 s are still apart in float32
  EXPECT_FALSE(std::filesystem::exists(path.parent_path() / "none.gltf"));
}

}  // namespace
}  // namespace t4d::formats
