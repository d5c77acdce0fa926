#include <fmt/format.h>

#include "formats/test_files.h"
#include "formats/triangle/mesh_bodies.h"

namespace t4d::formats {
namespace {

const std::string kPoints = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";

TEST(ObjReader, ReadsEveryFormOfACorner) {
  const auto loaded =
      readBytes("corners.obj", kPoints +
                                   "vt 0 0\nvn 0 0 1\nf 1 2 3\nf 1/1 2/1 4/1\nf 1//1 3//1 "
                                   "4//1\nf 2/1/1 3/1/1 4/-1/-1\nf -4 -3 -2\n");
  const std::vector<model::Triangle> expected{
      {0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}, {0, 1, 2}};
  EXPECT_EQ(loaded.mesh.triangles, expected);
}

TEST(ObjReader, KeepsTheNearestDouble) {
  const auto loaded = readBytes("digits.obj",
                                "v 0.1 +1.0 1e5 0.5\nv 1.7976931348623157e308 5e-324 "
                                "1e-400 1 0 0\nv .5 -1. 0.30000000000000004\nf 1 2 3");
  EXPECT_EQ(loaded.mesh.vertices[0], model::Point3(0.1, 1, 100000));
  EXPECT_EQ(loaded.mesh.vertices[1], model::Point3(1.7976931348623157e308, 5e-324, 0));
  EXPECT_EQ(loaded.mesh.vertices[2], model::Point3(0.5, -1, 0.1 + 0.2));
}

TEST(ObjReader, CopesWithTheLooseEndsOfRealFiles) {
  const auto loaded = readBytes(
      "loose.obj", "\xEF\xBB\xBF# comment\r\n#0 86\r\nmtllib a.mtl\r\no thing\r\n" + kPoints +
                       "\r\ns off\r\nusemtl m\r\nl 1 2\r\nf 1 \\\r\n 2 3\\\r\n"
                       "# no more\r\n\t f 1 2 4 # the end");
  EXPECT_EQ(loaded.mesh.triangles.size(), 2u);
  const auto mac = readBytes("mac.obj", "v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r");
  EXPECT_EQ(mac.mesh.triangles.size(), 1u);
}

TEST(ObjReader, KeepsColorsTextureCoordinatesAndMaterials) {
  const auto loaded = readBytes(
      "looks.obj",
      "v 0 0 0 0 0 0\nv 1 0 0 1 0 0\nv 0 1 0 0 1 0.2\nv 0 0 1 1 1 1\nvt 0 0\nvt 1 0\nvt 0 1\n"
      "f 1/1 2/2 3/3\nusemtl red steel\nf 1/3/1 3/-2 4/1\nusemtl\nf 2/1 4/1 3/3\n",
      Keep::Attributes);
  ASSERT_EQ(loaded.mesh.attributes.size(), 3U);
  auto colors = model::makeAttribute(
      "color", model::Domain::Vertex,
      std::vector<std::uint8_t>{0, 0, 0, 255, 0, 0, 0, 255, 51, 255, 255, 255});
  colors.components = 3;
  EXPECT_EQ(loaded.mesh.attributes[0], colors);
  auto uv = model::makeAttribute(
      "uv:corners", model::Domain::Cell,
      std::vector<float>{0, 0, 1, 0, 0, 1, 0, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 1});
  uv.components = 6;
  EXPECT_EQ(loaded.mesh.attributes[1], uv);
  EXPECT_EQ(loaded.mesh.attributes[2], model::makeAttribute("material", model::Domain::Cell,
                                                            std::vector<std::uint32_t>{0, 1, 0}));
  EXPECT_EQ(loaded.materials, (std::vector<std::string>{"", "red steel"}));
  EXPECT_TRUE(loaded.notices.empty());
}

TEST(ObjReader, SaysWhichLooksItLeavesOut) {
  const auto noticesOf = [](const std::string& rest) {
    std::string all;
    const auto shape = readBytes("a.obj", kPoints + rest).notices;
    const auto notices = readBytes("a.obj", kPoints + rest, Keep::Attributes).notices;
    for (std::size_t i = shape.size(); i < notices.size(); ++i) all += notices[i] + "; ";
    return all;
  };
  EXPECT_EQ(noticesOf("f 1 2 3\n"), "");
  EXPECT_EQ(noticesOf("mtllib a.mtl\nvn 0 0 1\nvt 1 1\nf 1/1 2/1 3/1\nf 1 2 4\n"),
            "3 of 6 corners of faces have no texture coordinates: 0 0 there; normals are not kept; "
            "materials and textures of 'a.mtl' are not kept, only names; ");
  EXPECT_EQ(
      noticesOf("vt 1 1\nf 1/1 2/1 3/2\n"),
      "texture coordinates left out: a face refers to texture coordinate 2, but there are 1; ");
  EXPECT_EQ(noticesOf("vt 1 1\nf 1/1 2/1 3/0\n"),
            "texture coordinates left out: line 6 refers to '0', but 1 come before it; ");
  EXPECT_EQ(noticesOf("v 0 0 0 9 9 9\nf 1 2 3\n"),
            "colours of vertices left out: line 5 has 9, expected numbers from 0 to 1; ");
  EXPECT_EQ(noticesOf("v 1 1 1 1 0 0\nf 1 2 5\n"), "4 of 5 vertices have no colour: white there; ");
}

TEST(ObjReader, DividesIntoObjectsAndGroups) {
  const std::filesystem::path path = writeFile(
      "parts.obj", kPoints +
                       "v 0 0 5\nf 1 2 5\no left arm\ng a\nf 1 2 3\nf 1 2 2\ng a b\no right\n"
                       "f 1 2 4\nf 1 3 4 2\ng\no left arm\nf 2 3 4\no empty\n");
  const auto counts = [&](BodiesBy by) {
    const auto loaded = readMeshBodies(path, by);
    EXPECT_TRUE(loaded) << loaded.error().text();
    EXPECT_EQ(loaded->notices.size(), 1U);
    std::string text;
    for (const NamedMesh& body : loaded->bodies) {
      text += fmt::format("{}: {} of {}; ", body.name, body.mesh.triangles.size(),
                          body.mesh.vertices.size());
    }
    return text;
  };
  EXPECT_EQ(counts(BodiesBy::Object), "parts: 1 of 3; left arm: 2 of 4; right: 3 of 4; ");
  EXPECT_EQ(counts(BodiesBy::Group), "parts: 1 of 3; a: 1 of 3; a b: 3 of 4; default: 1 of 3; ");
  EXPECT_FALSE(readMeshBodies("parts.stl", BodiesBy::Group));
}

TEST(ObjReader, BodiesKeepTheColoursOfTheirVertices) {
  const auto loaded = readMeshBodies(
      writeFile("colours.obj",
                "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nv 0 0 1 1 1 1\nv 1 1 1 0 0 0\n"
                "o one\nf 1 2 3\no other\nf 3 4 5\n"),
      BodiesBy::Object, Keep::Attributes);
  ASSERT_TRUE(loaded) << loaded.error().text();
  ASSERT_EQ(loaded->bodies.size(), 2U);
  for (const NamedMesh& body : loaded->bodies) {
    const auto colour = std::ranges::find(body.mesh.attributes, "color", &model::Attribute::name);
    ASSERT_NE(colour, body.mesh.attributes.end());
    ASSERT_EQ(colour->rows(), 3U);
  }
  const auto bytesOf = [&](std::size_t body) {
    std::string bytes;
    for (const std::byte byte :
         std::ranges::find(loaded->bodies[body].mesh.attributes, "color", &model::Attribute::name)
             ->values) {
      bytes += byte == std::byte{255} ? '1' : byte == std::byte{0} ? '0' : '?';
    }
    return bytes;
  };
  EXPECT_EQ(bytesOf(0), "100010001");
  EXPECT_EQ(bytesOf(1), "001111000");
}

TEST(ObjReader, SaysWhatIsWrongAndWhere) {
  EXPECT_EQ(errorOf("a.obj", kPoints + "f 1 2 abc\n"),
            "a.obj:5: found 'abc', expected a corner V, V/VT, V//VN or V/VT/VN");
  EXPECT_EQ(errorOf("a.obj", kPoints + "f 1 2 3/x\n"),
            "a.obj:5: found '3/x', expected a corner V, V/VT, V//VN or V/VT/VN");
  EXPECT_EQ(errorOf("a.obj", kPoints + "f 1 2 5\n"),
            "a.obj:5: a face refers to vertex 5, but there are 4 (counted from 1)");
  EXPECT_EQ(errorOf("a.obj", kPoints + "f 1 2 -5\n"),
            "a.obj:5: a face refers to vertex -5, but only 4 come before it");
  EXPECT_EQ(errorOf("a.obj", kPoints + "f 1 2 0\n"),
            "a.obj:5: a face refers to vertex 0, but OBJ counts from 1");
  EXPECT_EQ(errorOf("a.obj", kPoints + "f 1 2 5000000000\n"),
            "a.obj:5: a face refers to vertex 5000000000, beyond any that can exist");
  EXPECT_EQ(errorOf("a.obj", kPoints + "f 1 2 99999999999999999999\n"),
            "a.obj:5: found '99999999999999999999', expected a corner V, V/VT, V//VN or V/VT/VN");
  EXPECT_EQ(errorOf("a.obj", kPoints + "f 1 2\n"),
            "a.obj:5: a face of 2 corners, expected at "
            "least 3");
  EXPECT_EQ(errorOf("a.obj", "v 0 0\n"), "a.obj:1: the line ends, expected a coordinate");
  EXPECT_EQ(errorOf("a.obj", "v 0 0 1,5\n"), "a.obj:1: found '1,5', expected a coordinate");
  EXPECT_EQ(errorOf("a.obj", "v 0 0 0x1p3\n"), "a.obj:1: found '0x1p3', expected a coordinate");
  EXPECT_EQ(errorOf("a.obj", "v 0 0 nan\n"),
            "a.obj:1: vertex 1 is (0, 0, nan), expected finite coordinates");
  EXPECT_EQ(errorOf("a.obj", "v 0 0 -1e999\n"),
            "a.obj:1: vertex 1 is (0, 0, -inf), expected finite coordinates");
  EXPECT_EQ(errorOf("a.obj", kPoints), "a.obj: holds no triangles");
}

}  // namespace
}  // namespace t4d::formats
