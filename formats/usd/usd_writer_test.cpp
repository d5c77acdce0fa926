#include "formats/usd/usd_writer.h"

#include "formats/input_file.h"
#include "formats/test_files.h"

namespace t4d::formats {
namespace {

NamedMesh usdBox(double width, const std::string& name = "box") {
  NamedMesh named{name, {}};
  for (int i = 0; i < 8; ++i) {
    named.mesh.vertices.push_back(cubeCorner(i).cwiseProduct(model::Point3(width, 1, 1)));
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

std::size_t countOf(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (auto at = text.find(part); at != text.npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(UsdWriter, StoresAPackageAtAMultipleOf64) {
  const auto path = temporaryPath("package.usdz");
  ASSERT_TRUE(writeTriangleMeshes(path, std::vector{usdBox(1)}));
  const std::string bytes = platform::contents(path);
  EXPECT_EQ(bytes.find("#usda") % 64, 0U);
  EXPECT_EQ(bytes.substr(0, 4), "PK\x03\x04");
  EXPECT_EQ(loadNumber<std::uint16_t>(bytes.data() + 8), 0) << "stored";
}

TEST(UsdWriter, KeepsNamesThatAreNotAllowedAsDisplayNames) {
  const auto path = temporaryPath("names.usda");
  const std::vector meshes = {usdBox(1, "a b"), usdBox(1, "a_b"), usdBox(1, "7\"")};
  ASSERT_TRUE(writeTriangleMeshes(path, meshes));
  const std::string text = platform::contents(path);
  EXPECT_NE(text.find("def Mesh \"a_b\" (\n        displayName = \"a b\""), text.npos);
  EXPECT_NE(text.find("def Mesh \"a_b_1\" (\n        displayName = \"a_b\""), text.npos);
  EXPECT_NE(text.find("def Mesh \"_7_\" (\n        displayName = \"7\\\"\""), text.npos);
}

TEST(UsdWriter, SaysUnitsAxesAndOrigin) {
  const auto path = temporaryPath("placed.usda");
  MeshWriteOptions options;
  options.placement = {0.001, true, R"({"length_unit": "mm"})"};
  options.center = {1, 2, 3};
  ASSERT_TRUE(writeTriangleMeshes(path, std::vector{usdBox(1)}, options));
  const std::string text = platform::contents(path);
  for (const char* part :
       {"metersPerUnit = 0.001\n", "upAxis = \"Z\"\n", "string \"length_unit\" = \"mm\"\n",
        "double3 xformOp:translate = (1,2,3)\n"}) {
    EXPECT_NE(text.find(part), text.npos) << part;
  }
  EXPECT_NE(text.find("point3f[] points = [(-1,-2,-3)"), text.npos) << "of the Xform";
}

TEST(UsdWriter, WritesAttributesAsPrimvars) {
  NamedMesh named = usdBox(1);
  std::vector<double> heights;
  for (const auto& vertex : named.mesh.vertices) heights.push_back(vertex.z() + 0.1);
  std::vector<std::uint8_t> sides(12, 200);
  std::vector<std::int32_t> pairs(24, -3);
  auto pair = model::makeAttribute("a pair", model::Domain::Cell, pairs);
  pair.components = 2;
  std::vector<float> speeds(24, 0.5F);
  auto velocity = model::makeAttribute("velocity", model::Domain::Vertex, speeds);
  velocity.components = 3;
  std::vector<float> corners(72, 0.25F);
  auto uv = model::makeAttribute("uv:corners", model::Domain::Cell, corners);
  uv.components = 6;
  named.mesh.attributes = {model::makeAttribute("height", model::Domain::Vertex, heights),
                           model::makeAttribute("side", model::Domain::Cell, sides), pair, velocity,
                           uv};
  named.ownCorners = true;
  const auto path = temporaryPath("attributes.usda");
  const auto lost = writeTriangleMeshes(path, std::vector{named}, {.attributes = true});
  ASSERT_TRUE(lost) << lost.error().text();
  EXPECT_TRUE(lost->empty());
  const std::string text = platform::contents(path);
  for (const char* part :
       {"double[] primvars:height = [0.1,0.1,0.1,0.1,1.1,1.1,1.1,1.1] (\n"
        "            interpolation = \"vertex\"\n",
        "uchar[] primvars:side = [200,", "int2[] primvars:a_pair = [(-3,-3),",
        "vector3f[] velocities = [(0.5,0.5,0.5),", "texCoord2f[] primvars:st = [(0.25,0.25),",
        "interpolation = \"faceVarying\"", "interpolation = \"uniform\""}) {
    EXPECT_NE(text.find(part), text.npos) << part << "\n" << text;
  }
  ASSERT_TRUE(writeTriangleMeshes(path, std::vector{named}));
  const std::string plain = platform::contents(path);
  EXPECT_EQ(plain.find("velocities"), plain.npos);
  EXPECT_EQ(plain.find("primvars:"), plain.npos);
}

TEST(UsdWriter, WritesWhatStaysOnce) {
  const auto path = temporaryPath("still.usda");
  auto writer = UsdWriter::create(path, 24, 4);
  ASSERT_TRUE(writer) << writer.error().text();
  for (const double width : {1.0, 1.0, 1.0, 2.0}) {
    ASSERT_TRUE(writer->add(width, std::vector{usdBox(width)}));
  }
  ASSERT_TRUE(writer->finish());
  const std::string text = platform::contents(path);
  EXPECT_NE(text.find("int[] faceVertexIndices = ["), text.npos);
  // Players would move points from 0 to 3: they stay until 2.
  const std::size_t points = text.find("points.timeSamples");
  ASSERT_NE(points, text.npos);
  const std::string samples = text.substr(points, text.find('}', points) - points);
  EXPECT_EQ(countOf(samples, " 0: ") + countOf(samples, " 2: ") + countOf(samples, " 3: "), 3U);
  EXPECT_EQ(countOf(samples, " 1: "), 0U);
  EXPECT_NE(text.find("endTimeCode = 3\n"), text.npos);
}

TEST(UsdWriter, HoldsPointsWhereOthersTakeTheirNumbers) {
  const auto path = temporaryPath("changing.usda");
  auto writer = UsdWriter::create(path, 24, 2);
  ASSERT_TRUE(writer) << writer.error().text();
  ASSERT_TRUE(writer->add(0, std::vector{usdBox(1)}));
  NamedMesh other = usdBox(2);
  std::swap(other.mesh.triangles[0], other.mesh.triangles[1]);
  ASSERT_TRUE(writer->add(1, std::vector{other}));
  ASSERT_TRUE(writer->finish());
  const std::string text = platform::contents(path);
  const std::size_t points = text.find("points.timeSamples");
  EXPECT_NE(text.find("0.9999999999999999: [(0,0,0),(1,0,0)", points), text.npos);
  EXPECT_EQ(countOf(text, "0.9999999999999999: "), 2U) << "of points and extent";
}

TEST(UsdWriter, HidesWhatIsNotThere) {
  const auto path = temporaryPath("hidden.usda");
  auto writer = UsdWriter::create(path, 24, 3);
  ASSERT_TRUE(writer) << writer.error().text();
  ASSERT_TRUE(writer->add(0, std::vector{usdBox(1, "first")}));
  ASSERT_TRUE(writer->add(1, std::vector{usdBox(1, "first"), usdBox(2, "second")}));
  ASSERT_TRUE(writer->add(2, std::vector{NamedMesh{"first", {}}, usdBox(2, "second")}));
  ASSERT_TRUE(writer->finish());
  const std::string text = platform::contents(path);
  EXPECT_NE(text.find("token visibility.timeSamples = {\n            0: \"inherited\",\n"
                      "            2: \"invisible\",\n"),
            text.npos);
  EXPECT_NE(text.find("token visibility.timeSamples = {\n            0: \"invisible\",\n"
                      "            1: \"inherited\",\n"),
            text.npos);
}

TEST(UsdWriter, RefusesTextThatIsTooLarge) {
  const auto path = temporaryPath("large.usda");
  MeshWriteOptions options;
  options.usd.maxBytes = 100'000;
  auto writer = UsdWriter::create(path, 24, 1000, options);
  ASSERT_TRUE(writer) << writer.error().text();
  ASSERT_TRUE(writer->add(0, std::vector{usdBox(1)}));
  const auto second = writer->add(1, std::vector{usdBox(2)});
  ASSERT_FALSE(second);
  EXPECT_NE(second.error().message.find("value clip set"), std::string::npos)
      << second.error().message;
  options.usd.maxBytes = 100;
  EXPECT_FALSE(writeTriangleMeshes(path, std::vector{usdBox(1)}, options));
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(UsdWriter, RefusesWhatUsdDoesNotHold) {
  const auto path = temporaryPath("bad.usda");
  const auto errorOf = [&](const NamedMesh& named, const MeshWriteOptions& options = {}) {
    const auto lost = writeTriangleMeshes(path, std::vector{named}, options);
    return lost ? "(was written)" : textOf(lost.error(), path);
  };
  EXPECT_EQ(errorOf(usdBox(1), {.placement = {-1, false, ""}}),
            "bad.usda: -1 metres for a unit of length, expected more than 0");
  EXPECT_EQ(errorOf(usdBox(1), {.placement = {1, false, "[]"}}),
            "bad.usda: the extras are not a JSON object");
  EXPECT_EQ(errorOf(usdBox(1e39)).substr(0, 42), "bad.usda: mesh 'box': vertex 1 is (1e+39, ");
  NamedMesh fast = usdBox(1);
  auto velocity =
      model::makeAttribute("velocity", model::Domain::Vertex, std::vector<double>(24, 1e39));
  velocity.components = 3;
  fast.mesh.attributes = {velocity};
  EXPECT_EQ(errorOf(fast, {.attributes = true}),
            "bad.usda: mesh 'box': vertex 0 has a velocity of 1e+39, expected a number that "
            "float32 holds");
  const auto rate = UsdWriter::create(path, 0, 1);
  ASSERT_FALSE(rate);
  EXPECT_EQ(textOf(rate.error(), path), "bad.usda: 0 frames a second, expected more than 0");
  EXPECT_FALSE(UsdWriter::create(temporaryPath("bad.usdc"), 24, 1));
  EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace t4d::formats
