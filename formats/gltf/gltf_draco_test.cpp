#include "formats/gltf/gltf_draco.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "fixtures/solids.h"
#include "formats/gltf/gltf_animation.h"
#include "formats/test_files.h"

/// Files that Draco's own encoder compresses.
namespace t4d::formats {
namespace {

using model::Point3;
using nlohmann::json;

constexpr int kBits = 14;

/// With seams, each triangle has its own normals and texture coordinates.
std::unique_ptr<draco::Mesh> dracoMeshOf(const model::TriangleMesh& solid, bool seams) {
  using Attribute = draco::GeometryAttribute;
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(static_cast<int>(solid.triangles.size()));
  const int positions = builder.AddAttribute(Attribute::POSITION, 3, draco::DT_FLOAT32);
  const int normals = seams ? builder.AddAttribute(Attribute::NORMAL, 3, draco::DT_FLOAT32) : -1;
  const int uvs = seams ? builder.AddAttribute(Attribute::TEX_COORD, 2, draco::DT_FLOAT32) : -1;
  for (std::size_t i = 0; i < solid.triangles.size(); ++i) {
    const draco::FaceIndex face(static_cast<std::uint32_t>(i));
    std::array<Eigen::Vector3f, 3> at;
    for (std::size_t k = 0; k < 3; ++k) {
      at[k] = solid.vertices[solid.triangles[i][k]].cast<float>();
    }
    builder.SetAttributeValuesForFace(positions, face, at[0].data(), at[1].data(), at[2].data());
    if (!seams) continue;
    const Eigen::Vector3f normal = (at[1] - at[0]).cross(at[2] - at[0]).normalized();
    builder.SetPerFaceAttributeValueForFace(normals, face, normal.data());
    const float u = static_cast<float>(i) / static_cast<float>(solid.triangles.size());
    const std::array<Eigen::Vector2f, 3> uv = {Eigen::Vector2f{u, 0}, {u, 0.5F}, {u, 1}};
    builder.SetAttributeValuesForFace(uvs, face, uv[0].data(), uv[1].data(), uv[2].data());
  }
  return builder.Finalize();
}

Point3 positionOf(const draco::Mesh& mesh, std::size_t point) {
  const auto& positions = *mesh.GetNamedAttribute(draco::GeometryAttribute::POSITION);
  Eigen::Vector3f at;
  positions.GetMappedValue(draco::PointIndex(static_cast<std::uint32_t>(point)), at.data());
  return at.cast<double>();
}

/// A compressed mesh, and the glTF around it.
struct DracoFile {
  std::string bytes;
  json document;

  DracoFile(const draco::Mesh& mesh, int method) {
    draco::Encoder encoder;
    encoder.SetEncodingMethod(method);
    encoder.SetTrackEncodedProperties(true);
    encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, kBits);
    draco::EncoderBuffer buffer;
    EXPECT_TRUE(encoder.EncodeMeshToBuffer(mesh, &buffer).ok());
    bytes.assign(buffer.data(), buffer.size());
    document = {
        {"asset", {{"version", "2.0"}}},
        {"extensionsUsed", {kDracoExtension}},
        {"extensionsRequired", {kDracoExtension}},
        {"nodes", {{{"mesh", 0}}}},
        {"bufferViews", {{{"buffer", 0}, {"byteLength", bytes.size()}}}},
        {"accessors",
         {{{"componentType", 5125},
           {"type", "SCALAR"},
           {"count", 3 * encoder.num_encoded_faces()}}}},
        {"meshes", {{{"primitives", {{{"indices", 0}}}}}}},
    };
    const std::map<int, std::pair<const char*, const char*>> names = {
        {draco::GeometryAttribute::POSITION, {"POSITION", "VEC3"}},
        {draco::GeometryAttribute::NORMAL, {"NORMAL", "VEC3"}},
        {draco::GeometryAttribute::TEX_COORD, {"TEXCOORD_0", "VEC2"}}};
    for (int i = 0; i < mesh.num_attributes(); ++i) {
      const auto& [name, type] = names.at(mesh.attribute(i)->attribute_type());
      primitive()["attributes"][name] = document["accessors"].size();
      primitive()["extensions"][kDracoExtension]["attributes"][name] =
          mesh.attribute(i)->unique_id();
      document["accessors"].push_back(
          {{"componentType", 5126}, {"type", type}, {"count", encoder.num_encoded_points()}});
    }
    extension()["bufferView"] = 0;
  }

  json& primitive() { return document["meshes"][0]["primitives"][0]; }
  json& extension() { return primitive()["extensions"][kDracoExtension]; }

  /// An accessor of its own numbers, without compression.
  std::size_t addFloats(const std::vector<float>& numbers, const char* type, std::size_t width) {
    const std::size_t length = numbers.size() * sizeof(float);
    document["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", length}});
    bytes.append(reinterpret_cast<const char*>(numbers.data()), length);
    document["accessors"].push_back({{"bufferView", document["bufferViews"].size() - 1},
                                     {"componentType", 5126},
                                     {"type", type},
                                     {"count", numbers.size() / width}});
    return document["accessors"].size() - 1;
  }

  std::string text() {
    document["buffers"] = {{{"byteLength", bytes.size()}, {"uri", "draco.bin"}}};
    writeFile("draco.bin", bytes);
    return document.dump();
  }
};

/// The error about the primitive, without its place.
std::string problemOf(DracoFile& file) {
  const std::string text = errorOf("a.gltf", file.text());
  const std::string begin =
      "a.gltf: meshes[0].primitives[0]: is compressed by KHR_draco_mesh_compression and cannot be "
      "unpacked: ";
  EXPECT_EQ(text.substr(0, begin.size()), begin);
  return text.substr(std::min(text.size(), begin.size()));
}

constexpr std::array<int, 2> kMethods = {draco::MESH_SEQUENTIAL_ENCODING,
                                         draco::MESH_EDGEBREAKER_ENCODING};

/// The largest distance of a rounded position from the true one, for coordinates that span `size`.
double roundingOf(double size) { return std::sqrt(3) * 0.51 * size / ((1 << kBits) - 1); }

TEST(Draco, SolidsAreReadWithinTheirRounding) {
  for (const model::TriangleMesh& solid :
       {fixtures::icosphere(3, 2), fixtures::torus(4, 1, 12, 8), fixtures::hollowCube(4, 2)}) {
    const auto bounds = model::boundsOf(solid);
    const double rounding = roundingOf((bounds.max - bounds.min).maxCoeff());
    for (const int method : kMethods) {
      const auto read = readBytes("a.gltf", DracoFile(*dracoMeshOf(solid, false), method).text());
      EXPECT_TRUE(read.losses.empty());
      EXPECT_TRUE(model::isClosed(read.mesh));
      EXPECT_EQ(read.mesh.triangles.size(), solid.triangles.size());
      ASSERT_EQ(read.mesh.vertices.size(), solid.vertices.size());
      const double volume = model::signedVolume(solid);
      EXPECT_NEAR(model::signedVolume(read.mesh), volume, 1e-3 * volume);
      for (const Point3& vertex : read.mesh.vertices) {
        double nearest = 1;
        for (const Point3& true_ : solid.vertices) {
          nearest = std::min(nearest, (vertex - true_).norm());
        }
        EXPECT_LE(nearest, rounding);
      }
    }
  }
}

TEST(Draco, SeamsOfNormalsAndTexturesLeaveASolidClosed) {
  const model::TriangleMesh solid = fixtures::icosphere(3, 2);
  for (const int method : kMethods) {
    DracoFile file(*dracoMeshOf(solid, true), method);
    EXPECT_EQ(file.document["accessors"][1]["count"], 3 * solid.triangles.size());
    const auto read = readBytes("a.gltf", file.text(), Keep::Attributes);
    EXPECT_TRUE(model::isClosed(read.mesh));
    EXPECT_EQ(read.mesh.vertices.size(), solid.vertices.size());
    EXPECT_EQ(read.mesh.triangles.size(), solid.triangles.size());
    ASSERT_EQ(read.mesh.attributes.size(), 1U);
    EXPECT_EQ(read.mesh.attributes[0].name, "uv:corners");
    EXPECT_THAT(read.losses,
                testing::ElementsAre("normals: only positions, triangles and TEXCOORD_0 are read"));
  }
}

/// The specification leaves targets uncompressed: they have the order of sequential encoding, which
/// is that of the points.
TEST(Draco, MorphTargetsMoveThePointsInTheirOrder) {
  const auto mesh = dracoMeshOf(fixtures::icosphere(3, 2), true);
  const auto displaced = [](const Point3& p) { return Point3(p.y(), 2 * p.z(), p.x()); };
  DracoFile file(*mesh, draco::MESH_SEQUENTIAL_ENCODING);
  std::vector<float> target;
  for (std::size_t i = 0; i < mesh->num_points(); ++i) {
    for (const double x : displaced(positionOf(*mesh, i))) target.push_back(static_cast<float>(x));
  }
  file.primitive()["targets"] = {{{"POSITION", file.addFloats(target, "VEC3", 3)}}};
  const auto times = file.addFloats({0, 1}, "SCALAR", 1);
  const auto weights = file.addFloats({0, 1}, "SCALAR", 1);
  file.document["animations"] = {
      {{"samplers", {{{"input", times}, {"output", weights}}}},
       {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}}}};
  const auto scene = readGltfAnimation({temporaryPath("a.gltf"), file.text()}, {});
  ASSERT_TRUE(scene) << scene.error().text();
  const auto& [name, solid, runs, tolerance] = scene->bodies.at(0);
  EXPECT_TRUE(model::isClosed(solid));
  std::vector<Point3> moved(solid.vertices.size());
  ASSERT_TRUE(runs.at(0)->positions(runs[0]->count() - 1, moved));
  for (std::size_t i = 0; i < moved.size(); ++i) {
    EXPECT_LE((moved[i] - solid.vertices[i] - displaced(solid.vertices[i])).norm(),
              3 * roundingOf(6));
  }
}

TEST(Draco, PlainDataIsTakenAsItIs) {
  DracoFile file(*dracoMeshOf(fixtures::cube(2), false), draco::MESH_EDGEBREAKER_ENCODING);
  file.document.erase("extensionsRequired");
  file.primitive().erase("indices");
  file.primitive()["attributes"]["POSITION"] =
      file.addFloats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3", 3);
  file.bytes[0] = 'x';
  EXPECT_EQ(readBytes("a.gltf", file.text()).mesh.triangles.size(), 1U);
}

TEST(Draco, SharedMeshesAreUnpackedOnce) {
  DracoFile file(*dracoMeshOf(fixtures::cube(2), true), draco::MESH_EDGEBREAKER_ENCODING);
  json other = file.primitive();
  file.document["meshes"][0]["primitives"].push_back(other);
  EXPECT_EQ(readBytes("a.gltf", file.text()).mesh.triangles.size(), 24U);
  other["extensions"][kDracoExtension]["attributes"].erase("NORMAL");
  file.document["meshes"][0]["primitives"].push_back(other);
  EXPECT_EQ(errorOf("a.gltf", file.text()),
            "a.gltf: meshes[0].primitives[2]: is compressed by KHR_draco_mesh_compression and "
            "cannot be unpacked: primitives take different parts of one mesh");
}

TEST(Draco, WhatDoesNotFitTheAccessorsIsRefused) {
  const auto mesh = dracoMeshOf(fixtures::cube(2), true);
  const auto problemWith = [&](const std::function<void(DracoFile&)>& change) {
    DracoFile file(*mesh, draco::MESH_EDGEBREAKER_ENCODING);
    change(file);
    return problemOf(file);
  };
  EXPECT_EQ(problemWith([](auto& file) { file.document["accessors"][0]["count"] = 30; }),
            "it has 36 corners of triangles, but the accessor 30");
  EXPECT_EQ(problemWith([](auto& file) { file.document["accessors"][1]["count"] = 24; }),
            "POSITION has 24 elements, but NORMAL has 36");
  EXPECT_EQ(problemWith([](auto& file) {
              for (int i = 1; i < 4; ++i) file.document["accessors"][i]["count"] = 4'000'000'000;
            }),
            "it has 36 points, but the accessors 4000000000");
  EXPECT_EQ(problemWith([](auto& file) { file.extension()["attributes"]["NORMAL"] = 7; }),
            "it has no attribute 7");
  EXPECT_EQ(problemWith([](auto& file) { file.extension()["attributes"]["COLOR_0"] = 1; }),
            "its extension has COLOR_0, but the primitive has no such accessor");
  EXPECT_EQ(problemWith([](auto& file) { file.document["accessors"][1]["type"] = "VEC2"; }),
            "its attribute 0 has elements of 3 numbers, but the accessor 2");
  EXPECT_EQ(problemWith([](auto& file) { file.document["accessors"][1]["type"] = "MAT4"; }),
            "POSITION lacks a number, count, component type or type");
  EXPECT_EQ(problemWith([](auto& file) { file.document["accessors"][1]["componentType"] = 5123; }),
            "its attribute 0 has values that are not of component type 5123");
  EXPECT_EQ(problemWith([](auto& file) { file.extension()["attributes"] = json::object(); }),
            "its extension names no attributes");
  EXPECT_EQ(problemWith([](auto& file) { file.extension().erase("bufferView"); }),
            "its extension lacks bufferView or attributes");
  EXPECT_EQ(problemWith([](auto& file) { file.extension()["bufferView"] = 1; }),
            "buffer view 1 does not exist");
  EXPECT_THAT(problemWith([](auto& file) { file.document["bufferViews"][0]["byteOffset"] = 1; }),
              testing::StartsWith("buffer view 0 is "));
}

TEST(Draco, DamagedBytesAreReadOrRefused) {
  const auto mesh = dracoMeshOf(fixtures::cube(2), false);
  const DracoFile whole(*mesh, draco::MESH_EDGEBREAKER_ENCODING);
  for (std::size_t size = 1; size < whole.bytes.size(); ++size) {
    DracoFile file = whole;
    file.bytes.resize(size);
    file.document["bufferViews"][0]["byteLength"] = size;
    EXPECT_FALSE(problemOf(file).empty());
  }
  for (std::size_t i = 0; i < whole.bytes.size(); ++i) {
    DracoFile file = whole;
    file.bytes[i] = static_cast<char>(~file.bytes[i]);
    const auto path = writeFile("a.gltf", file.text());
    const auto loaded = readTriangleMesh(path);  // read as other numbers, or refused
    EXPECT_TRUE(loaded || loaded.error().where.file == path.string());
  }
}

}  // namespace
}  // namespace t4d::formats
