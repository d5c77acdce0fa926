#include "formats/test_files.h"

namespace t4d::formats {
namespace {

const std::string kBody = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

TEST(OffReader, ReadsHeadersWithAndWithoutPrefixes) {
  for (const std::string header : {"OFF\n3 1 0\n", "OFF 3 1 0\n", "OFF\n3 1\n", "COFF\n3 1 3\n",
                                   "NOFF # normals\n# counts\n3 1 0\n\n", "STCNOFF\n3 1 0\n"}) {
    EXPECT_EQ(readBytes("a.off", header + kBody).mesh.triangles.size(), 1u) << header;
  }
}

TEST(OffReader, IgnoresColumnsAfterPositionsAndCorners) {
  const auto loaded = readBytes("a.off",
                                "CNOFF\n4 1 0\n0 0 0 0 0 1 255 0 0 255\n1 0 0 0 0 1 red\n"
                                "1 1 0\n0 1 0\n4 0 1 2 3 0.5 0.5 0.5\n");
  EXPECT_EQ(loaded.mesh.triangles.size(), 2u);
  EXPECT_EQ(model::surfaceArea(loaded.mesh), 1);
}

TEST(OffReader, SaysWhatIsWrongAndWhere) {
  EXPECT_EQ(errorOf("a.off", "4OFF\n5 10 10 5\n"),
            "a.off:1: is '4OFF', not a mesh in three dimensions; expected 'OFF'");
  EXPECT_EQ(errorOf("a.off", "nOFF\n3\n3 1 0\n"),
            "a.off:1: is 'nOFF', not a mesh in three dimensions; expected 'OFF'");
  EXPECT_EQ(errorOf("a.off", "OFF BINARY\n"), "a.off:1: is binary OFF, which is not supported");
  EXPECT_EQ(errorOf("a.off", "3 1 0\n" + kBody), "a.off:1: found '3', expected 'OFF'");
  EXPECT_EQ(errorOf("a.off", "OFF\n999999999 1 0\n" + kBody),
            "a.off:2: declares 999999999 vertices, which the 29 bytes that follow cannot hold");
  EXPECT_EQ(errorOf("a.off", "OFF\n3 -1 0\n" + kBody),
            "a.off:2: declares -1 faces, which the 29 bytes that follow cannot hold");
  EXPECT_EQ(errorOf("a.off", "OFF\n3 2 0\n" + kBody), "a.off:6: the file ends after 1 of 2 faces");
  EXPECT_EQ(errorOf("a.off", "OFF\n3 1 0\n" + kBody + "3 0 1 2\n"),
            "a.off:7: found '3', expected the end of the file after 1 faces");
  EXPECT_EQ(errorOf("a.off", "OFF\n3 1 0\n0 0 0\n1 0\n0 1 0\n3 0 1 2\n"),
            "a.off:4: the line ends, expected a coordinate");
  EXPECT_EQ(errorOf("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
            "a.off:6: a face refers to vertex 3, but there are 3 (counted from 0)");
  EXPECT_EQ(errorOf("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n"),
            "a.off:6: a face refers to vertex -1; expected 0 or more");
  EXPECT_EQ(errorOf("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n900000000 0 1 2\n"),
            "a.off:6: the line ends, expected the number of a vertex");
  EXPECT_EQ(errorOf("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n"),
            "a.off:6: a face of 2 corners, expected at least 3");
  EXPECT_EQ(errorOf("a.off", "OFF\n0 0 0\n"), "a.off: holds no triangles");
}

}  // namespace
}  // namespace t4d::formats
