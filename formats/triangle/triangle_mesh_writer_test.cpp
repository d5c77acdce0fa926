#include <random>

#include "formats/test_files.h"
#include "formats/triangle/triangle_mesh_formats.h"
#include "t4d/surface.h"
#include "tests/paths.h"

namespace t4d::formats {
namespace {

/// A closed mesh of clean numbering whose coordinates need all of a double's digits.
NamedMesh tetrahedron(unsigned seed, const std::string& name = "tetrahedron") {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> coordinate(-1e3, 1e3);
  NamedMesh named{name, {}};
  for (int i = 0; i < 4; ++i) {
    named.mesh.vertices.emplace_back(coordinate(random), coordinate(random), coordinate(random));
  }
  named.mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  return named;
}

LoadedMesh writtenAndRead(const std::string& file, const std::vector<NamedMesh>& meshes) {
  const auto path = temporaryPath(file);
  const auto lost = writeTriangleMeshes(path, meshes);
  EXPECT_TRUE(lost) << lost.error().text();
  const auto loaded = readTriangleMesh(path);
  EXPECT_TRUE(loaded) << loaded.error().text();
  return loaded ? *loaded : LoadedMesh{};
}

TEST(TriangleMeshWriter, ObjAndPlyKeepEveryBit) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    const auto named = tetrahedron(seed);
    for (const char* file : {"a.obj", "a.ply", "a.off"}) {
      const auto loaded = writtenAndRead(file, {named});
      EXPECT_EQ(loaded.mesh.vertices, named.mesh.vertices) << file;
      EXPECT_EQ(loaded.mesh.triangles, named.mesh.triangles) << file;
      EXPECT_TRUE(loaded.notices.empty());
    }
  }
}

TEST(TriangleMeshWriter, StlRoundsToFloat32AndKeepsTheSurface) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    const auto named = tetrahedron(seed);
    const auto loaded = writtenAndRead("a.stl", {named});
    EXPECT_TRUE(model::isClosed(loaded.mesh));
    for (const auto& vertex : named.mesh.vertices) {
      const model::Point3 rounded = vertex.cast<float>().cast<double>();
      EXPECT_EQ(std::ranges::count(loaded.mesh.vertices, rounded), 1);
    }
  }
}

TEST(TriangleMeshWriter, ObjKeepsTextureCoordinatesOfCornersAndVertices) {
  std::vector<NamedMesh> two{tetrahedron(1, "corners"), tetrahedron(2, "vertices")};
  std::vector<float> ofCorners;
  for (int i = 0; i < 24; ++i) ofCorners.push_back(static_cast<float>(i) / 7);
  const std::vector<float> ofVertices = {0.1F, 0.2F, 0.3F, 0.4F, 0.5F, 0.6F, 0.7F, 0.8F};
  auto corners = model::makeAttribute("uv:corners", model::Domain::Cell, ofCorners);
  corners.components = 6;
  two[0].mesh.attributes = {corners};
  auto vertices = model::makeAttribute("uv", model::Domain::Vertex, ofVertices);
  vertices.components = 2;
  two[1].mesh.attributes = {
      vertices, model::makeAttribute("heat", model::Domain::Vertex, std::vector<float>(4))};
  std::vector<float> expected = ofCorners;
  for (const model::Triangle& triangle : two[1].mesh.triangles) {
    for (const std::uint32_t i : triangle) {
      expected.insert(expected.end(), {ofVertices[2 * i], ofVertices[2 * i + 1]});
    }
  }
  auto both = model::makeAttribute("uv:corners", model::Domain::Cell, expected);
  both.components = 6;
  for (const auto& normals : {std::optional<NormalStyle>(), std::optional(NormalStyle{})}) {
    const auto path = temporaryPath("uv.obj");
    const auto lost = writeTriangleMeshes(path, two, {.attributes = true, .normals = normals});
    ASSERT_TRUE(lost) << lost.error().text();
    EXPECT_EQ(*lost, std::vector<std::string>{"vertex attribute 'heat': OBJ has no attributes but "
                                              "texture coordinates, opaque colours of vertices in "
                                              "bytes, and materials"});
    const auto loaded = readTriangleMesh(path, Keep::Attributes);
    ASSERT_TRUE(loaded) << loaded.error().text();
    EXPECT_EQ(loaded->mesh.attributes, std::vector{both});
    ASSERT_TRUE(writeTriangleMeshes(path, two, {.normals = normals}));
    EXPECT_EQ(platform::contents(path).find("vt "), std::string::npos);
  }
}

TEST(TriangleMeshWriter, JoinsSeveralMeshes) {
  const std::vector<NamedMesh> two{tetrahedron(1, "one"), tetrahedron(2, "two\nlines")};
  const double volume = model::signedVolume(two[0].mesh) + model::signedVolume(two[1].mesh);
  for (const char* file : {"a.obj", "a.ply", "a.off", "a.STL"}) {
    const auto loaded = writtenAndRead(file, two);
    EXPECT_EQ(loaded.mesh.vertices.size(), 8u) << file;
    EXPECT_NEAR(model::signedVolume(loaded.mesh), volume, 1e-5 * std::abs(volume)) << file;
  }
  EXPECT_NE(platform::contents(temporaryPath("a.obj")).find("\no two lines\nv "),
            std::string::npos);
}

TEST(TriangleMeshWriter, WritesMeshesWithoutTriangles) {
  for (const char* file : {"a.obj", "a.ply", "a.off", "a.stl"}) {
    const auto path = temporaryPath(file);
    ASSERT_TRUE(writeTriangleMeshes(path, std::vector<NamedMesh>{{"nothing", {}}})) << file;
    EXPECT_EQ(readTriangleMesh(path).error().message, "holds no triangles") << file;
  }
}

TEST(TriangleMeshWriter, PlyKeepsAttributesThatAllMeshesHave) {
  auto named = tetrahedron(1);
  using model::Domain;
  named.mesh.attributes = {
      model::makeAttribute<float>("heat flux", Domain::Vertex, {1, 2, 3, 4}),
      model::makeAttribute<std::int64_t>("source", Domain::Cell, {10, 11, 12, 1LL << 53}),
      model::makeAttribute<std::uint64_t>("key", Domain::Cell, {1, 2, 3, ~0ULL}),
      model::makeAttribute<double>("x", Domain::Vertex, {1, 2, 3, 4}),
      model::makeAttribute<double>("short", Domain::Vertex, {1, 2})};
  const auto path = temporaryPath("attributes.ply");
  const auto lost = writeTriangleMeshes(path, std::vector{named}, {.attributes = true});
  ASSERT_TRUE(lost) << lost.error().text();
  EXPECT_EQ(*lost,
            (std::vector<std::string>{
                "vertex attribute 'x': another has the same name",
                "vertex attribute 'short': its rows do not fit the mesh",
                "triangle attribute 'key': PLY has no 64-bit integers, and some are not exact "
                "in a double"}));
  const std::string bytes = platform::contents(path);
  const std::string declared =
      "property double z\nproperty float heat_flux\nelement face 4\nproperty list uchar int "
      "vertex_indices\nproperty double source\nend_header\n";
  ASSERT_NE(bytes.find(declared), std::string::npos);
  EXPECT_EQ(bytes.size(), bytes.find(declared) + declared.size() + 4 * (24 + 4) + 4 * (13 + 8));
  EXPECT_EQ(bytes.substr(bytes.size() - 8), bytesOf(9007199254740992.0));
  EXPECT_EQ(readTriangleMesh(path)->mesh.triangles, named.mesh.triangles);

  const std::vector<NamedMesh> two{named, tetrahedron(2, "bare")};
  EXPECT_EQ(writeTriangleMeshes(path, two, {.attributes = true})->front(),
            "vertex attribute 'heat flux': mesh 'bare' does not have it");
}

TEST(TriangleMeshWriter, NamesTheDirectionsOfVelocities) {
  NamedMesh named = tetrahedron(1);
  model::Attribute velocity{"velocity", model::Domain::Vertex, model::ScalarType::Float64, 3};
  velocity.values.resize(named.mesh.vertices.size() * velocity.rowBytes());
  named.mesh.attributes = {velocity};
  const auto has = [&](const char* name, std::string_view part) {
    const auto path = temporaryPath(name);
    EXPECT_TRUE(writeTriangleMeshes(path, {&named, 1}, {.attributes = true}));
    return platform::contents(path).find(part) != std::string::npos;
  };
  EXPECT_TRUE(has("a.ply",
                  "property double velocity_x\nproperty double velocity_y\n"
                  "property double velocity_z\n"));
  EXPECT_TRUE(has("a.vtp", "<PointData Vectors=\"velocity\">"));
  EXPECT_TRUE(has("a.gltf", "\"_VELOCITY\""));
}

TEST(TriangleMeshWriter, ListsTheAttributesThatAreLost) {
  auto named = tetrahedron(1);
  named.mesh.attributes = {model::makeAttribute<double>("a", model::Domain::Cell, {1, 2, 3, 4})};
  const auto path = temporaryPath("lost.stl");
  EXPECT_TRUE(writeTriangleMeshes(path, std::vector{named})->empty());
  EXPECT_EQ(*writeTriangleMeshes(path, std::vector{named, named}, {.attributes = true}),
            std::vector<std::string>{"triangle attribute 'a': STL has no room for attributes"});
}

TEST(TriangleMeshWriter, RefusesWhatCannotBeWritten) {
  auto named = tetrahedron(1);
  EXPECT_EQ(writeTriangleMeshes("a.xyz", std::vector{named}).error().text(),
            "a.xyz: unsupported output extension; a triangle mesh can be written as " +
                writableTriangleMeshExtensions());
  const auto path = temporaryPath("refused.stl");
  named.mesh.vertices[2].x() = 1e39;
  EXPECT_EQ(writeTriangleMeshes(path, std::vector{named}).error().where.text(),
            path.string() + ": mesh 'tetrahedron'");
  named.mesh.triangles[1][0] = 4;
  EXPECT_EQ(writeTriangleMeshes(path, std::vector{named}).error().message,
            "triangle 1 refers to vertex 4, but there are 4 (counted from 0)");
  named.mesh.vertices[0].y() = std::nan("");
  EXPECT_FALSE(writeTriangleMeshes(path, std::vector{named}));
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(TriangleMeshWriter, WritesRealMeshesThatReadBackTheSame) {
  const std::filesystem::path source = std::filesystem::path(T4D_SHARED_MESHES) / "goathead.obj";
  if (!std::filesystem::exists(source)) GTEST_SKIP() << "no file " << source;
  const auto mesh = readTriangleMesh(source)->mesh;
  for (const char* file : {"goat.obj", "goat.ply"}) {
    const auto loaded = writtenAndRead(file, {{"goat", mesh}});
    EXPECT_EQ(loaded.mesh.vertices, mesh.vertices);
    EXPECT_EQ(loaded.mesh.triangles, mesh.triangles);
  }
  EXPECT_NEAR(model::signedVolume(writtenAndRead("goat.stl", {{"goat", mesh}}).mesh),
              421.7366604893, 1e-4);
}

}  // namespace
}  // namespace t4d::formats
