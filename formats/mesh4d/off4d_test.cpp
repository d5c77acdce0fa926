#include <fmt/format.h>

#include "formats/mesh4d/polyhedron.h"
#include "formats/mesh4d/test_mesh4d.h"
#include "t4d/file.h"

namespace t4d::formats {
namespace {

TEST(StellaOff, RegularPolytopesHaveTheirHypervolume) {
  for (const fixtures::Polytope& polytope : fixtures::polytopes()) {
    LoadedMesh4d loaded = read4dBytes("polytope.off", fixtures::offText(polytope));
    EXPECT_EQ(loaded.dialect, "Stella");
    ASSERT_EQ(loaded.bodies.size(), 1U);
    turnOutward(loaded.bodies[0]);
    EXPECT_NEAR(hypervolumeOf(loaded.bodies), polytope.hypervolume, 1e-12) << polytope.name;
  }
}

TEST(StellaOff, RefusesWhatCannotBeOneSurface) {
  const std::string head = "4OFF\n4 4 6 2\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n";
  const std::string faces = "3 0 1 2\n3 0 1 3\n3 0 2 3\n3 1 2 3\n";
  EXPECT_EQ(error4dOf("a.off", head + faces + "4 0 1 2 3\n"),
            "a.off:11: the file ends after 1 of 2 cells");
  EXPECT_EQ(error4dOf("a.off", head + faces + "4 0 1 2 3\n4 0 1 2 4\n"),
            "a.off:12: found 4, expected a face from 0 to 3");
  EXPECT_EQ(error4dOf("a.off", head + "2 0 1\n"), "a.off:7: a face has fewer than 3 corners");
  EXPECT_EQ(error4dOf("a.off", head + faces + "3 0 1 2\n"),
            "a.off:11: a cell has fewer than 4 faces");
  EXPECT_EQ(error4dOf("a.off", "4OFF\n4 4 6 999999999999\n0 0 0 0\n"),
            "a.off:2: the number of cells is 999999999999, which the 9 bytes that follow cannot "
            "hold");
  EXPECT_EQ(error4dOf("a.off", "4OFF\n1 1 1 1\n0 0 nan 0\n"),
            "a.off:3: a coordinate is not finite");
  EXPECT_EQ(error4dOf("a.off", "4OFF\n1 1 1 1\n0 0 0\n"),
            "a.off:3: the line ends, expected a coordinate (a vertex has four)");
}

TEST(IjkOff, IsReadWithCommentsAfterItsHeader) {
  const LoadedMesh4d loaded = read4dBytes(
      "ijk.off",
      "4OFF\r\n# made by a program\r\n5 5 0\r\n0 0 0 0\r\n1 0 0 0\r\n0 1 0 0\r\n0 0 1 0\r\n"
      "0 0 0 1e0\r\n4 1 2 3 4\r\n4 2 0 3 4\r\n4 0 1 3 4\r\n4 1 0 2 4\r\n4 0 1 2 3\r\n");
  EXPECT_EQ(loaded.dialect, "IJK");
  ASSERT_EQ(loaded.bodies.size(), 1U);
  EXPECT_DOUBLE_EQ(hypervolumeOf(loaded.bodies), 1.0 / 24);
}

TEST(IjkOff, ATinyOrHugeSimplexIsNotFlat) {
  for (const double size : {1e-70, 1e-45, 1e45, 1e70}) {
    const LoadedMesh4d loaded = read4dBytes(
        "ijk.off", fmt::format("4OFF\n5 5 0\n{0} 0 0 0\n0 {0} 0 0\n0 0 {0} 0\n0 0 0 {0}\n0 0 0 0\n"
                               "4 0 1 2 3\n4 0 1 2 4\n4 0 1 3 4\n4 0 2 3 4\n4 1 2 3 4\n",
                               size));
    EXPECT_EQ(loaded.dialect, "IJK") << size;
  }
}

TEST(StellaOff, OtherRanksAreNamed) {
  EXPECT_EQ(error4dOf("a.off", "5OFF\n6 15 20 15 6\n"),
            "a.off: is 5OFF, a polytope in 5 dimensions; a 4D mesh is 4OFF");
}

TEST(GeomviewOff, IsToldApartAndRefused) {
  EXPECT_EQ(error4dOf("a.off", "nOFF 4\n3 1 0\n0 0 0 0\n1 0 0 0\n0 1 0 0\n3 0 1 2\n"),
            "a.off: is Geomview's OFF, which has polygons only; a 4D mesh needs tetrahedra, as the "
            "OFF of Stella or IJK has");
  // Homogeneous coordinates, with triangles and with squares.
  EXPECT_EQ(error4dOf("a.off", "4OFF\n3 1 0\n0 0 0 1\n1 0 0 1\n0 1 0 1\n3 0 1 2\n"),
            "a.off:6: found an element with 3 corners, expected a tetrahedron: this is Geomview's "
            "OFF, which has polygons and homogeneous coordinates, not a 4D mesh");
  EXPECT_EQ(error4dOf("a.off", "4OFF\n4 1 0\n0 0 0 1\n1 0 0 1\n1 1 0 1\n0 1 0 1\n4 0 1 2 3\n"),
            "a.off: all elements are flat: this is Geomview's OFF, which has polygons and "
            "homogeneous coordinates, not a 4D mesh");
}

TEST(GeomviewOff, IsWrittenAsTriangles) {
  const auto path = written4d(*mesh4dFormat("off-geomview"), {awkwardBody("", 0)});
  const std::string text = platform::contents(path);
  EXPECT_TRUE(text.starts_with("nOFF\n4\n8 32 24\n")) << text.substr(0, 40);
  EXPECT_EQ(std::ranges::count(text, '\n'), 3 + 8 + 32);
}

TEST(Polyhedron, NeighboursSplitTheirCommonFaceAlike) {
  // Two cubes with a common square, each with its own order of faces and corners.
  const std::vector<std::vector<std::uint32_t>> faces = {
      {0, 2, 3, 1},   {4, 5, 7, 6},  {0, 1, 5, 4},  {2, 6, 7, 3}, {0, 4, 6, 2},  {1, 3, 7, 5},
      {8, 10, 11, 9}, {10, 8, 4, 6}, {9, 11, 7, 5}, {8, 9, 5, 4}, {11, 10, 6, 7}};
  const auto trianglesOf = [&](std::initializer_list<int> which) {
    std::vector<std::span<const std::uint32_t>> solid;
    for (const int face : which) solid.emplace_back(faces[face]);
    std::vector<std::array<std::uint32_t, 3>> onSquare;
    int count = 0;
    pullPolyhedron(solid, [&](const model::Cell& cell) {
      ++count;
      for (int out = 0; out < 4; ++out) {
        std::array<std::uint32_t, 3> triangle{};
        for (int i = 0, k = 0; i < 4; ++i) {
          if (i != out) triangle[k++] = cell[i];
        }
        std::ranges::sort(triangle);
        if (triangle[0] >= 4 && triangle[2] <= 7) onSquare.push_back(triangle);
      }
    });
    EXPECT_EQ(count, 6);
    std::ranges::sort(onSquare);
    return onSquare;
  };
  EXPECT_EQ(trianglesOf({0, 1, 2, 3, 4, 5}), trianglesOf({6, 7, 8, 9, 10, 1}));
}

}  // namespace
}  // namespace t4d::formats
