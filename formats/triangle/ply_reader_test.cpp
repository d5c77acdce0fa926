#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "formats/test_files.h"

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

/// A prism of height 1 over a regular polygon with n corners, in strips: its side, its top and its
/// bottom. Vertices 0 to n - 1 are those of the top, the others are below them.
struct StripPrism {
  static constexpr int kCorners = 7;
  static constexpr int kVertices = 2 * kCorners;

  static double volume() { return kCorners * std::sin(2 * std::numbers::pi / kCorners) / 2; }

  static std::vector<float> coordinates() {
    std::vector<float> all;
    for (const float z : {1.0F, 0.0F}) {
      for (int i = 0; i < kCorners; ++i) {
        const double angle = 2 * std::numbers::pi * i / kCorners;
        all.insert(all.end(),
                   {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)), z});
      }
    }
    return all;
  }

  static std::vector<int> side() {
    std::vector<int> strip;
    for (int i = 0; i <= kCorners; ++i) {
      strip.push_back(i % kCorners);
      strip.push_back(i % kCorners + kCorners);
    }
    return strip;
  }

  /// Across the polygon and back: 0, 1, n - 1, 2, n - 2, ...
  static std::vector<int> top() {
    std::vector<int> strip{0};
    for (int i = 1; strip.size() < kCorners; ++i) {
      strip.push_back(i);
      if (strip.size() < kCorners) strip.push_back(kCorners - i);
    }
    return strip;
  }

  static std::vector<int> bottom() {
    auto strip = top();
    for (int& corner : strip) corner = kCorners + (kCorners - corner) % kCorners;
    return strip;
  }
};

std::vector<int> joined(const std::vector<std::vector<int>>& lists) {
  std::vector<int> all;
  for (const auto& list : lists) all.insert(all.end(), list.begin(), list.end());
  return all;
}

/// A PLY file of the prism's vertices and these rows of faces and strips.
std::string plyOf(const std::string& format, const std::vector<std::vector<int>>& faces,
                  const std::vector<std::vector<int>>& strips) {
  std::string elements = "element vertex " + std::to_string(StripPrism::kVertices) +
                         "\nproperty float x\nproperty float y\nproperty float z\n";
  if (!faces.empty()) {
    elements +=
        "element face " + std::to_string(faces.size()) + "\nproperty list int int vertex_indices\n";
  }
  elements += "element tristrips " + std::to_string(strips.size()) +
              "\nproperty list int int vertex_indices\n";
  std::string bytes = header(format, elements);
  const bool text = format == "ascii";
  const bool big = format == "binary_big_endian";
  const auto put = [&](auto value) {
    bytes += text ? fmt::format("{} ", value) : ordered(value, big);
  };
  const auto coordinates = StripPrism::coordinates();
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    put(coordinates[i]);
    if (text && i % 3 == 2) bytes += "\n";
  }
  for (const auto& rows : {faces, strips}) {
    for (const auto& row : rows) {
      put(static_cast<int>(row.size()));
      for (const int entry : row) put(entry);
      if (text) bytes += "\n";
    }
  }
  return bytes;
}

TEST(PlyReader, TriangleStripsBoundTheSolidThatTheyBoundInAnyFormAndByteOrder) {
  const auto side = StripPrism::side();
  const auto top = StripPrism::top();
  const auto bottom = StripPrism::bottom();
  struct Case {
    const char* what;
    std::vector<std::vector<int>> faces;
    std::vector<std::vector<int>> strips;
  };
  const std::vector<int> restart{-1};
  std::vector<int> topFace;
  for (int i = 0; i < StripPrism::kCorners; ++i) topFace.push_back(i);
  const std::vector<Case> cases = {
      {"a row for each strip", {}, {side, top, bottom}},
      {"one row, restarted", {}, {joined({side, restart, top, restart, bottom})}},
      {"empty strips",
       {},
       {{}, joined({restart, side, restart, restart, top, restart, bottom, restart})}},
      // Eighteen corners stand before the bottom's first, so that it is not turned over.
      {"joined by triangles with two equal corners",
       {},
       {joined({side, {side.back(), bottom.front()}, bottom}), top}},
      {"beside faces", {topFace}, {side, bottom}}};
  for (const auto& [what, faces, strips] : cases) {
    for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
      SCOPED_TRACE(std::string(what) + ", " + format);
      const auto loaded = readBytes("strips.ply", plyOf(format, faces, strips));
      EXPECT_TRUE(model::isClosed(loaded.mesh));
      EXPECT_EQ(loaded.mesh.vertices.size(), std::size_t{StripPrism::kVertices});
      EXPECT_EQ(loaded.mesh.triangles.size(), 4u * StripPrism::kCorners - 4);
      EXPECT_NEAR(model::signedVolume(loaded.mesh), StripPrism::volume(), 1e-6);
      EXPECT_TRUE(loaded.notices.empty());
    }
  }
}

TEST(PlyReader, JudgesTheIndicesOfStripsAsThoseOfFaces) {
  const auto errorAfter = [](const std::vector<std::vector<int>>& strips) {
    return errorOf("a.ply", plyOf("ascii", {}, strips));
  };
  EXPECT_EQ(errorAfter({{0, 1, 2}, {0, 1, 14}}),
            "a.ply:26: a face refers to vertex 14, but there are 14 (counted from 0)");
  // Indices are checked even if they make no triangle.
  EXPECT_EQ(errorAfter({{0, 1, 2}, {0, 0, 99}}),
            "a.ply:26: a face refers to vertex 99, but there are 14 (counted from 0)");
  EXPECT_EQ(errorAfter({{0, 1, 2, -1, 99}}),
            "a.ply:25: a face refers to vertex 99, but there are 14 (counted from 0)");
  EXPECT_EQ(errorAfter({{0, 1, -2}}),
            "a.ply:25: a face refers to vertex -2, expected a whole number from 0 on");
  EXPECT_EQ(errorOf("a.ply", plyOf("ascii", {{0, 1, -1}}, {{0, 1, 2}})),
            "a.ply:27: a face refers to vertex -1, expected a whole number from 0 on");
  EXPECT_EQ(errorAfter({{0, 0, 1, 1}}), "a.ply: holds no triangles");
}

TEST(PlyReader, SaysWhatIsWrongWithTheHeader) {
  EXPECT_EQ(errorOf("a.ply", "plyx\n"), "a.ply:1: found 'plyx', expected 'ply'");
  EXPECT_EQ(errorOf("a.ply", "ply\nformat ascii 1.0\n"),
            "a.ply:2: the file ends, expected 'end_header'");
  EXPECT_EQ(errorOf("a.ply", "ply\nformat binary 1.0\n"),
            "a.ply:2: found 'binary', expected 'ascii', 'binary_little_endian' or "
            "'binary_big_endian'");
  EXPECT_EQ(errorOf("a.ply", header("ascii", "element vertex -3\n")),
            "a.ply:4: declares -3 elements");
  EXPECT_EQ(errorOf("a.ply", header("ascii", "element vertex 3\nproperty half x\n")),
            "a.ply:5: found 'half', expected a type such as 'float' or 'uint8'");
  EXPECT_EQ(errorOf("a.ply", header("ascii", "element vertex 3\nproperty float x\n")),
            "a.ply:6: the header ends, expected one element 'vertex' with properties 'x', 'y' and "
            "'z'");
  EXPECT_EQ(errorOf("a.ply", header("ascii", kElements.substr(0, kElements.find("element face")))),
            "a.ply:8: the header ends, expected an element 'face' or 'tristrips' with a list "
            "'vertex_indices'");
  EXPECT_EQ(errorOf("a.ply", header("ascii", kElements + "element face 1\n")),
            "a.ply:11: the header ends, expected at most one element 'face'");
}

TEST(PlyReader, SaysWhatIsWrongWithTheData) {
  const std::string text = header("ascii", kElements);
  EXPECT_EQ(errorOf("a.ply", text + "0 0 0\n1 0 0\n0 1 0\n"),
            "a.ply:13: the file ends after 0 of 1 of element 'face'");
  EXPECT_EQ(errorOf("a.ply", text + "0 0 0\n1 0 0 5\n0 1 0\n3 0 1 2\n"),
            "a.ply:12: found '5', expected the end of the line");
  EXPECT_EQ(errorOf("a.ply", text + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2.5\n"),
            "a.ply:14: a face refers to vertex 2.5, expected a whole number from 0 on");
  EXPECT_EQ(errorOf("a.ply", text + "0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n"),
            "a.ply:14: a face refers to vertex 7, but there are 3 (counted from 0)");
  EXPECT_EQ(errorOf("a.ply", text + "0 0 0\n1 0 0\n0 1 0\n-1 0 1 7\n"),
            "a.ply:14: a list of length -1, expected 0 to 4");

  const std::string binary = header("binary_little_endian", kElements);
  const auto size = std::to_string(binary.size());
  EXPECT_EQ(errorOf("a.ply", binary + "12345"),
            "a.ply: byte " + size +
                ": declares 3 of element 'vertex', more than the 5 bytes after the header can "
                "hold");
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
                ": declares 4000000000000 of element 'vertex', more than the 60 bytes after the "
                "header can hold");
}

TEST(PlyReader, ReadsColorsAndTextureCoordinatesOfVertices) {
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
      "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
      "property float s\nproperty float t\nelement face 2\n"
      "property list uchar int vertex_indices\nend_header\n";
  const std::string faces = "3 0 1 2\n3 3 2 1\n";
  const LoadedMesh loaded = readBytes("a.ply",
                                      header +
                                          "0 0 0 1 2 3 0.5 0.25\n1 0 0 4 5 6 1 0\n"
                                          "0 1 0 7 8 9 0 1\n0 0 1 250 251 252 2 3\n" +
                                          faces,
                                      Keep::Attributes);
  ASSERT_EQ(loaded.mesh.attributes.size(), 2U);
  auto colors =
      model::makeAttribute("color", model::Domain::Vertex,
                           std::vector<std::uint8_t>{1, 2, 3, 4, 5, 6, 7, 8, 9, 250, 251, 252});
  colors.components = 3;
  auto uv = model::makeAttribute("uv", model::Domain::Vertex,
                                 std::vector<float>{0.5, 0.25, 1, 0, 0, 1, 2, 3});
  uv.components = 2;
  EXPECT_EQ(loaded.mesh.attributes[0], colors);
  EXPECT_EQ(loaded.mesh.attributes[1], uv);
  // Two points of one place, with two colours.
  const LoadedMesh seam = readBytes("a.ply",
                                    header +
                                        "0 0 0 1 2 3 0 0\n1 0 0 4 5 6 0 0\n"
                                        "0 1 0 7 8 9 0 0\n0 0 0 250 251 252 0 0\n" +
                                        faces,
                                    Keep::Attributes);
  EXPECT_EQ(seam.mesh.vertices.size(), 3U);
  ASSERT_EQ(seam.mesh.attributes.size(), 2U);
  auto corners = model::makeAttribute(
      "color:corners", model::Domain::Cell,
      std::vector<std::uint8_t>{1, 2, 3, 4, 5, 6, 7, 8, 9, 250, 251, 252, 7, 8, 9, 4, 5, 6});
  corners.components = 9;
  EXPECT_EQ(seam.mesh.attributes[0], corners);
  EXPECT_EQ(seam.mesh.attributes[1].domain, model::Domain::Vertex);
  EXPECT_TRUE(seam.notices.empty());
}

}  // namespace
}  // namespace t4d::formats
