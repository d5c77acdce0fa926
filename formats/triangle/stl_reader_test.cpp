#include "formats/test_files.h"

namespace t4d::formats {
namespace {

std::string binaryStl(const std::string& start, std::uint32_t count, float shift = 0) {
  std::string bytes = start;
  bytes.resize(80, ' ');
  bytes += bytesOf(count);
  for (const auto& square : kCubeSquares) {
    for (const auto& corners : {std::array{0, 1, 2}, std::array{0, 2, 3}}) {
      bytes += std::string(12, '\0');
      for (const int corner : corners) {
        for (const double x : cubeCorner(square[corner])) bytes += bytesOf(float(x) + shift);
      }
      bytes += "ab";
    }
  }
  return bytes;
}

const std::string kFacet =
    "facet normal nan nan nan\n outer loop\n  vertex 0 0 0\n  vertex +1.0 0 0\n"
    "  vertex 0 1e0 0\n endloop\nendfacet\n";

TEST(StlReader, MergesTheCornersOfABinaryCube) {
  const auto loaded = readBytes("cube.stl", binaryStl("cube", 12));
  EXPECT_EQ(loaded.mesh.vertices.size(), 8u);
  EXPECT_EQ(loaded.mesh.triangles.size(), 12u);
  EXPECT_TRUE(model::isClosed(loaded.mesh));
  EXPECT_EQ(model::signedVolume(loaded.mesh), 1);
  EXPECT_TRUE(loaded.notices.empty());
}

TEST(StlReader, TellsBinaryByItsSizeThoughItBeginsWithSolid) {
  EXPECT_EQ(readBytes("solid.stl", binaryStl("solid cube", 12)).mesh.triangles.size(), 12u);
}

TEST(StlReader, ReadsTextInAnyCaseWithSeveralSolids) {
  const std::string upper =
      "SOLID\nFACET NORMAL 0 0 0 OUTER LOOP VERTEX 0 0 0 VERTEX 0 1 0 VERTEX "
      "0 0 -1\r\nENDLOOP ENDFACET ENDSOLID\n";
  const auto loaded =
      readBytes("text.stl", "solid two words\n" + kFacet + "endsolid two words\n" + upper);
  EXPECT_EQ(loaded.mesh.triangles.size(), 2u);
  EXPECT_EQ(loaded.mesh.vertices.size(), 4u);
  EXPECT_EQ(loaded.mesh.vertices[3], model::Point3(0, 0, -1));
}

TEST(StlReader, SaysWhatIsWrongWithABinaryFile) {
  auto short1 = binaryStl("cube", 12);
  short1.pop_back();
  EXPECT_EQ(errorOf("short.stl", short1),
            "short.stl: byte 80: the count is 12 triangles, for which the file must have 684 "
            "bytes; it has 683");
  EXPECT_EQ(errorOf("many.stl", binaryStl("solid", 0xffffffff).replace(5, 1, 1, '\0')),
            "many.stl: byte 80: the count is 4294967295 triangles, for which the file must have "
            "214748364834 bytes; it has 684");
  EXPECT_EQ(errorOf("junk.stl", "junk"),
            "junk.stl: neither begins with 'solid' nor has the 84 bytes of a binary header: the "
            "file ends after 4");
  EXPECT_EQ(errorOf("none.stl", std::string(84, '\0')), "none.stl: holds no triangles");
  EXPECT_EQ(errorOf("nan.stl", binaryStl("cube", 12, std::numeric_limits<float>::infinity())),
            "nan.stl: byte 96: vertex 0 is (inf, inf, inf), expected finite coordinates");
}

TEST(StlReader, SaysWhatIsWrongWithATextFile) {
  EXPECT_EQ(errorOf("cut.stl", "solid\n" + kFacet),
            "cut.stl:8: the file ends, expected 'facet' or "
            "'endsolid'");
  EXPECT_EQ(errorOf("word.stl", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 zero\n"),
            "word.stl:4: found 'zero', expected a coordinate");
  EXPECT_EQ(errorOf("quad.stl",
                    "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
                    "vertex 1 1 0\nvertex 0 1 0\n"),
            "quad.stl:7: found 'vertex', expected 'endloop'");
  // Each word of a facet is required.
  const std::string solid = "solid\n" + kFacet + "endsolid\n";
  for (const std::string word : {"normal", "outer", "loop", "vertex", "endloop", "endfacet"}) {
    std::string other = solid;
    other.replace(other.find(word), word.size(), "other");
    EXPECT_NE(errorOf("other.stl", other).find("found 'other', expected '" + word + "'"),
              std::string::npos)
        << errorOf("other.stl", other);
  }
  EXPECT_EQ(errorOf("empty.stl", "solid\nendsolid\n"), "empty.stl: holds no triangles");
}

}  // namespace
}  // namespace t4d::formats
