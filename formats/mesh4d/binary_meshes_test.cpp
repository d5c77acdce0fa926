#include <fmt/format.h>

#include "formats/mesh4d/test_mesh4d.h"
#include "t4d/file.h"

/// Binary Gmsh and Medit meshes, byte by byte as their formats are published.
namespace t4d::formats {
namespace {

constexpr double kSimplexHypervolume4 = 1.0 / 24;
constexpr std::array<std::array<int, 4>, 5> kSimplexCells = {
    {{1, 2, 3, 4}, {2, 0, 3, 4}, {0, 1, 3, 4}, {1, 0, 2, 4}, {0, 1, 2, 3}}};

/// Bytes in either order.
class Bytes {
 public:
  explicit Bytes(std::endian order) : order_(order) {}

  template <class T>
  Bytes& add(T number) {
    std::string bytes = bytesOf(number);
    if (order_ == std::endian::big) std::ranges::reverse(bytes);
    text += bytes;
    return *this;
  }
  Bytes& put(const std::string& more) {
    text += more;
    return *this;
  }

  std::string text;

 private:
  std::endian order_;
};

using I = std::int32_t;
using L = std::uint64_t;

/// A simplex with other entities, elements, sections and data. `nodes`: the count of a block.
std::string gmshSimplex(std::endian order, L nodes = 4, L elements = 5, I type = 4) {
  Bytes out(order);
  out.put("$MeshFormat\n4.1 1 8\n").add(I{1}).put("\n$EndMeshFormat\n");
  out.put("$PhysicalNames\n2\n2 5 \"side\"\n3 5 \"a body\"\n$EndPhysicalNames\n$Entities\n");
  for (const L count : {L{1}, L{0}, L{1}, L{1}}) out.add(count);
  out.add(I{1}).add(0.0).add(0.0).add(0.0).add(L{0});  // a point
  for (const I tag : {7, 9}) {                         // a surface, a volume
    out.add(tag);
    for (int i = 0; i < 6; ++i) out.add(1.0);
    out.add(L{2}).add(I{5}).add(I{6}).add(L{1}).add(I{-1});
  }
  out.put("\n$EndEntities\n$Nodes\n").add(L{2}).add(L{5}).add(L{10}).add(L{50});
  // One node on a surface, with two parameters; four in the volume.
  out.add(I{2}).add(I{7}).add(I{1}).add(L{1}).add(L{10});
  for (const double number : {0.0, 0.0, 0.0, 0.25, 0.5}) out.add(number);
  out.add(I{3}).add(I{9}).add(I{0}).add(nodes);
  for (const L tag : {20, 30, 40, 50}) out.add(tag);
  for (int node = 0; node < 4; ++node) {
    for (int axis = 0; axis < 3; ++axis) out.add(axis == node ? 1.0 : 0.0);
  }
  out.put("\n$EndNodes\n$Elements\n").add(L{2}).add(L{6}).add(L{1}).add(L{6});
  out.add(I{2}).add(I{7}).add(I{2}).add(L{1}).add(L{1}).add(L{10}).add(L{20}).add(L{30});
  out.add(I{3}).add(I{9}).add(type).add(elements);
  L number = 1;
  for (const auto& cell : kSimplexCells) {
    out.add(++number);
    for (const int corner : cell) out.add(L{10} + 10 * static_cast<L>(corner));
  }
  out.put("\n$EndElements\n$Periodic\n").add(L{0}).put("\n$EndPeriodic\n");
  out.put("$NodeData\n1\n\"speed\"\n0\n3\n0\n1\n0\n\n$EndNodeData\n");
  out.put("$NodeData\n1\n\"time\"\n1\n0.0\n3\n0\n1\n5\n");
  for (I node = 1; node <= 5; ++node) out.add(10 * node).add(node == 5 ? 1.0 : 0.0);
  return out.put("\n$EndNodeData\n").text;
}

TEST(GmshBinary, IsReadInBothByteOrdersWithOtherSections) {
  for (const std::endian order : {std::endian::little, std::endian::big}) {
    const LoadedMesh4d loaded = read4dBytes("a.msh", gmshSimplex(order));
    ASSERT_EQ(loaded.bodies.size(), 1U);
    EXPECT_EQ(loaded.bodies[0].name, "a body");
    EXPECT_DOUBLE_EQ(hypervolumeOf(loaded.bodies), kSimplexHypervolume4);
    EXPECT_EQ(loaded.losses.size(), 1U);  // the speed
  }
}

TEST(GmshBinary, CutAnywhereOrWithWrongCountsIsRefused) {
  const std::string whole = gmshSimplex(std::endian::little);
  const std::string end = "$EndNodeData";
  for (std::size_t size = 30; size < whole.rfind(end) + end.size(); ++size) {
    EXPECT_NE(error4dOf("cut.msh", whole.substr(0, size)), "(was accepted)") << size;
  }
  EXPECT_EQ(
      error4dOf("a.msh", gmshSimplex(std::endian::little, L{1} << 60)),
      "a.msh: byte 478: declares 1152921504606846976 nodes of 32 bytes, but 650 bytes follow");
  EXPECT_EQ(error4dOf("a.msh", gmshSimplex(std::endian::little, 3)),
            "a.msh: byte 574: found other bytes, expected $EndNodes");
  EXPECT_EQ(error4dOf("a.msh", gmshSimplex(std::endian::little, 4, L{1} << 61)),
            "a.msh: byte 731: declares 2305843009213693952 elements of 40 bytes, but 397 bytes "
            "follow");
  EXPECT_EQ(error4dOf("a.msh", gmshSimplex(std::endian::little, 4, 5, 11)),
            "a.msh: byte 711: has 5 elements of type 11, expected tetrahedra of four nodes (4)");
  std::string crowded = whole;
  crowded[crowded.find("$Entities") + 10 + 3] = 1;
  EXPECT_NE(error4dOf("a.msh", crowded).find("declares 16777217 entities of 36 bytes, but"),
            std::string::npos);
  std::string beyond = whole;
  beyond[731 + 8] = 21;
  EXPECT_EQ(error4dOf("a.msh", beyond), "a.msh: byte 739: refers to node 21, which does not exist");
  EXPECT_EQ(error4dOf("a.msh", "$MeshFormat\n4.1 1 4\n"),
            "a.msh: byte 12: is of the format '4.1 1 4', expected '4.1 1 8': MSH 4.1, binary, "
            "sizes of 8 bytes; Gmsh writes it with `-format msh41 -bin`");
}

/// A simplex with edges and corners. `vertices` and `next`: what the file says of the vertices.
std::string meditSimplex(I version, std::endian order, std::int64_t vertices = 5,
                         std::int64_t next = 0) {
  Bytes out(order);
  const auto integer = [&](std::int64_t value) {
    version == 4 ? out.add(value) : out.add(static_cast<I>(value));
  };
  const std::size_t width = version == 4 ? 8 : 4;
  const auto keyword = [&](I number, std::size_t bytes) {
    out.add(number);
    const std::size_t end = out.text.size() + (version >= 3 ? 8 : 4) + bytes;
    const auto position = static_cast<std::int64_t>(number == 4 && next > 0 ? next : end);
    version >= 3 ? out.add(position) : out.add(static_cast<I>(position));
  };
  out.add(I{1}).add(version);
  keyword(3, 4);
  out.add(I{4});
  keyword(4, width + 5 * (4 * (version == 1 ? 4 : 8) + width));
  integer(vertices);
  for (int vertex = 0; vertex < 5; ++vertex) {
    for (int axis = 0; axis < 4; ++axis) {
      const double coordinate = axis + 1 == vertex ? 1 : 0;
      version == 1 ? out.add(static_cast<float>(coordinate)) : out.add(coordinate);
    }
    integer(7);
  }
  keyword(5, 4 * width);  // edges
  for (const int number : {1, 1, 2, 3}) integer(number);
  keyword(13, 2 * width);  // corners
  for (const int number : {1, 1}) integer(number);
  keyword(8, width + 25 * width);
  integer(5);
  for (const auto& cell : kSimplexCells) {
    for (const int corner : cell) integer(corner + 1);
    integer(0);
  }
  return out.add(I{54}).text;
}

TEST(MeditBinary, IsReadInEachVersionAndByteOrder) {
  for (const std::endian order : {std::endian::little, std::endian::big}) {
    for (I version = 1; version <= 4; ++version) {
      const LoadedMesh4d loaded = read4dBytes("a.meshb", meditSimplex(version, order));
      EXPECT_DOUBLE_EQ(hypervolumeOf(loaded.bodies), kSimplexHypervolume4);
      EXPECT_EQ(loaded.dialect, fmt::format("version {}{}", version,
                                            order == std::endian::big ? ", big-endian" : ""));
      ASSERT_EQ(loaded.losses.size(), 1U);
      EXPECT_TRUE(loaded.losses[0].ends_with("a.meshb: '1' 'Edges' are not read"));
    }
  }
}

TEST(MeditBinary, CutAnywhereOrWithWrongCountsIsRefused) {
  for (I version = 1; version <= 4; ++version) {
    const std::string whole = meditSimplex(version, std::endian::little);
    for (std::size_t size = 8; size < whole.size(); ++size) {
      const std::string error = error4dOf("cut.meshb", whole.substr(0, size));
      EXPECT_TRUE(error.starts_with("cut.meshb: byte ")) << size << ": " << error;
    }
  }
  const auto errorOf = [](std::int64_t vertices, std::int64_t next) {
    return error4dOf("a.meshb", meditSimplex(3, std::endian::little, vertices, next));
  };
  EXPECT_EQ(errorOf(2'000'000'000, 0),
            "a.meshb: byte 40: declares 2000000000 vertices of 36 bytes, but 348 bytes follow");
  EXPECT_EQ(errorOf(-1, 0), "a.meshb: byte 36: the count is -1, expected 0 or more");
  EXPECT_EQ(errorOf(4, 0),
            "a.meshb: byte 184: the elements of keyword 4 end here, but the next keyword is at "
            "byte 220");
  EXPECT_EQ(errorOf(5, 24),
            "a.meshb: byte 24: the keyword 4 is followed by one at byte 24, expected 37 to 388");
  EXPECT_EQ(errorOf(5, std::int64_t{1} << 40),
            "a.meshb: byte 24: the keyword 4 is followed by one at byte 1099511627776, expected 37 "
            "to 388");
  std::string space = meditSimplex(3, std::endian::little);
  space[20] = 3;
  EXPECT_EQ(error4dOf("a.meshb", space), "a.meshb: byte 20: is a mesh of dimension 3, expected 4");
}

}  // namespace
}  // namespace t4d::formats
