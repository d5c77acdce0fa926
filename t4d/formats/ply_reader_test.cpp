#include <algorithm>

#include "t4d/formats/test_files.h"

namespace t4d::formats {
namespace {

std::string header(const std::string& format, const std::string& elements) {
  return "ply\nformat " + format + " 1.0\ncomment made by hand\n" + elements + "end_header\n";
}

const std::string kElements =
    "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\n";
const std::string kText = header("ascii", kElements) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

template <class T>
std::string ordered(T value, bool big) {
  auto bytes = bytesOf(value);
  if (big) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

TEST(PlyReader, ReadsText) {
  const auto loaded = readBytes("a.ply", kText);
  EXPECT_EQ(loaded.mesh.vertices[1], model::Point3(1, 0, 0));
  EXPECT_EQ(loaded.mesh.triangles, (std::vector<model::Triangle>{{0, 1, 2}}));
}

TEST(PlyReader, ReadsBothByteOrdersWithAnyOrderAndTypeOfProperties) {
  for (const bool big : {false, true}) {
    std::string bytes =
        header(big ? "binary_big_endian" : "binary_little_endian",
               "element camera 1\nproperty int16 id\nproperty list uint8 float32 lens\n"
               "element vertex 4\nproperty uchar red\nproperty double z\nproperty list ushort "
               "double weights\nproperty int8 y\nproperty float64 x\nelement face 1\n"
               "property list char float texcoord\nproperty list int ushort vertex_index\n"
               "element edge 1\nproperty int vertex1\n");
    bytes += ordered<std::int16_t>(7, big) + "\x01" + ordered(0.5F, big);
    for (int i = 0; i < 4; ++i) {
      bytes += "\xff" + ordered(0.1 * i, big) + ordered<std::uint16_t>(1, big) + ordered(2.5, big) +
               bytesOf<std::int8_t>(i / 2 ? -1 : 1) + ordered(i % 3 ? 1.0 : 0.0, big);
    }
    bytes += std::string(1, '\x01') + ordered(0.25F, big) + ordered<std::int32_t>(4, big);
    for (std::uint16_t i = 0; i < 4; ++i) bytes += ordered(i, big);
    bytes += ordered<std::int32_t>(3, big);
    const auto loaded = readBytes("a.ply", bytes);
    ASSERT_EQ(loaded.mesh.vertices.size(), 4u);
    EXPECT_EQ(loaded.mesh.vertices[3], model::Point3(0, -1, 0.1 * 3));
    EXPECT_EQ(loaded.mesh.triangles.size(), 2u);
  }
}

TEST(PlyReader, ReadsBinaryDataAfterAHeaderWithDosLineEnds) {
  std::string text = header("binary_little_endian", kElements);
  std::string bytes;
  for (const char c : text) bytes += c == '\n' ? std::string("\r\n") : std::string(1, c);
  for (const float x : {0, 0, 0, 1, 0, 0, 0, 1, 0}) bytes += bytesOf(x);
  bytes += "\x03" + bytesOf(0) + bytesOf(1) + bytesOf(2);
  EXPECT_EQ(readBytes("a.ply", bytes).mesh.triangles.size(), 1u);
}

TEST(PlyReader, SaysWhatIsWrongWithTheHeader) {
  EXPECT_EQ(errorOf("a.ply", "plyx\n"), "a.ply:1: found 'plyx', expected 'ply'");
  EXPECT_EQ(errorOf("a.ply", "ply\nformat ascii 1.0\n"),
            "a.ply:2: the file ends, expected 'end_header'");
  EXPECT_EQ(errorOf("a.ply", "ply\nformat binary 1.0\n"),
            "a.ply:2: found 'binary', expected 'ascii', 'binary_little_endian' or "
            "'binary_big_endian'");
  EXPECT_EQ(errorOf("a.ply", header("ascii", "element vertex -3\n")), "a.ply:4: says -3 elements");
  EXPECT_EQ(errorOf("a.ply", header("ascii", "element vertex 3\nproperty half x\n")),
            "a.ply:5: found 'half', expected a type such as 'float' or 'uint8'");
  EXPECT_EQ(errorOf("a.ply", header("ascii", "element vertex 3\nproperty float x\n")),
            "a.ply:6: the header ends, expected one element 'vertex' with properties 'x', 'y' and "
            "'z'");
  EXPECT_EQ(errorOf("a.ply", header("ascii", kElements.substr(0, kElements.find("element face")))),
            "a.ply:8: the header ends, expected one element 'face' with a list 'vertex_indices'");
}

TEST(PlyReader, SaysWhatIsWrongWithTheData) {
  const std::string text = header("ascii", kElements);
  EXPECT_EQ(errorOf("a.ply", text + "0 0 0\n1 0 0\n0 1 0\n"),
            "a.ply:13: the file ends after 0 of 1 of element 'face'");
  EXPECT_EQ(errorOf("a.ply", text + "0 0 0\n1 0 0 5\n0 1 0\n3 0 1 2\n"),
            "a.ply:12: found '5', expected the end of the line");
  EXPECT_EQ(errorOf("a.ply", text + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2.5\n"),
            "a.ply:14: a face names vertex 2.5, expected a whole number from 0 on");
  EXPECT_EQ(errorOf("a.ply", text + "0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n"),
            "a.ply:14: a face names vertex 7, but there are 3 (counted from 0)");
  EXPECT_EQ(errorOf("a.ply", text + "0 0 0\n1 0 0\n0 1 0\n-1 0 1 7\n"),
            "a.ply:14: a list of length -1, expected 0 to 4");

  const std::string binary = header("binary_little_endian", kElements);
  const auto size = std::to_string(binary.size());
  EXPECT_EQ(errorOf("a.ply", binary + "12345"),
            "a.ply: byte " + size +
                ": says 3 of element 'vertex', which cannot stand in the 5 "
                "bytes that follow the header");
  EXPECT_EQ(errorOf("a.ply", binary + std::string(36, '\0') + "\x03" + std::string(11, '\0')),
            "a.ply: byte " + std::to_string(binary.size() + 37) +
                ": a list of length 3, expected 0 to 2");
  EXPECT_EQ(errorOf("a.ply", binary + std::string(12, '\0') + bytesOf(std::nanf("")) +
                                 std::string(40, '\0')),
            "a.ply: byte " + std::to_string(binary.size() + 12) +
                ": vertex 1 is (nan, 0, 0), expected finite coordinates");

  auto many = header("binary_little_endian", kElements);
  many.replace(many.find("vertex 3"), 8, "vertex 4000000000000");
  EXPECT_EQ(errorOf("a.ply", many + std::string(60, '\0')),
            "a.ply: byte " + std::to_string(many.size()) +
                ": says 4000000000000 of element 'vertex', which cannot stand in the 60 bytes that "
                "follow the header");
}

}  // namespace
}  // namespace t4d::formats
