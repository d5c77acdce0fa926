#include "formats/mesh4d/test_mesh4d.h"
#include "t4d/file.h"

/// 4DO, Medit, MFEM, Gmsh and TetGen as other programs write them.
namespace t4d::formats {
namespace {

// The five tetrahedra of a 4-simplex with corners at the origin and the unit points.
constexpr double kSimplex = 1.0 / 24;

TEST(Fourdo, IsReadWithColoursNormalsAndAnyCase) {
  const LoadedMesh4d loaded = read4dBytes("a.4do",
                                          "# header\n4DO 1\norient X Y Z W\n\nv 0 0 0 0\n"
                                          "V  1  0  0   0 # any blanks\nv 0 1 0 0\nv 0 0 1 0\n"
                                          "v 0 0 0 +1\nvn 0 0 0 1\nco 0x72FF42\n"
                                          "tformat co v/vn\nt 0 1/0 2/0 3/0 4/0\n"
                                          "t 0 2/0 0/0 3/0 4/0\nt 0 0/0 1/0 3/0 4/0\n"
                                          "t 0 1/0 0/0 2/0 4/0\nt 0 0/0 1/0 2/0 3/0\nc 0 1\n");
  ASSERT_EQ(loaded.bodies.size(), 1U);
  EXPECT_DOUBLE_EQ(hypervolumeOf(loaded.bodies), kSimplex);
  EXPECT_EQ(loaded.dialect, "version 1");
  EXPECT_TRUE(loaded.losses.empty());
}

TEST(Fourdo, OrientTurnsAxesAndKeepsTheSolidOutward) {
  const std::string rest =
      "v 0 0 0 0\nv 2 0 0 0\nv 0 1 0 0\nv 0 0 1 0\nv 0 0 0 1\n"
      "t 1 2 3 4\nt 2 0 3 4\nt 0 1 3 4\nt 1 0 2 4\nt 0 1 2 3\np 0 1\n";
  for (const std::string orient : {"X Y Z W", "-Y W X -Z", "W Z Y X", "-X Y Z W"}) {
    const LoadedMesh4d loaded = read4dBytes("a.4do", "4DO 1\norient " + orient + "\n" + rest);
    EXPECT_DOUBLE_EQ(hypervolumeOf(loaded.bodies), 2 * kSimplex) << orient;
    EXPECT_EQ(loaded.losses.size(), 1U);
  }
  const LoadedMesh4d turned = read4dBytes("a.4do", "4DO 1\norient -Y W X -Z\n" + rest);
  EXPECT_EQ(turned.bodies[0].vertices[1], model::Point4(0, 0, 2, 0));
  EXPECT_EQ(turned.bodies[0].vertices[3], model::Point4(0, 0, 0, -1));
}

TEST(Fourdo, SaysWhatIsWrong) {
  EXPECT_EQ(error4dOf("a.4do", "4DO 3\n"), "a.4do:1: is 4DO version 3, expected 1 or 2");
  EXPECT_EQ(error4dOf("a.4do", "4DO 1\nv 0 0 0 0\nt 0 1 2 3\n"),
            "a.4do:3: a tetrahedron refers to vertex 1, but there are 1 so far, numbered from 0");
  EXPECT_EQ(error4dOf("a.4do", "4DO 1\nv 0 0 0 inf\n"), "a.4do:2: a coordinate is not finite");
  EXPECT_EQ(error4dOf("a.4do", "4DO 1\norient X X Z W\n"),
            "a.4do:2: found 'X', expected each of X, Y, Z and W once, with or without a sign");
  EXPECT_EQ(error4dOf("a.4do", "4DO 1\nv 0 0 0 0\n"), "a.4do: holds no tetrahedra");
}

const std::string kMeditSimplex =
    "Vertices\n5\n0 0 0 0 7\n1 0 0 0 7\n0 1 0 0 7\n0 0 1 0 7\n0 0 0 1 7\n";
const std::string kMeditTetrahedra =
    "Tetrahedra\n5\n2 3 4 5 0\n3 1 4 5 0\n1 2 4 5 0\n2 1 3 5 0\n1 2 3 4 0\n";

TEST(Medit, IsReadWithSectionsOfOtherElements) {
  const LoadedMesh4d loaded =
      read4dBytes("a.mesh", "MeshVersionFormatted\n1\n\nDimension\n4\n# c\n" + kMeditSimplex +
                                "Edges 1\n1 2 3\nRidges\n1\n1\n" + kMeditTetrahedra + "\nEnd\n");
  EXPECT_DOUBLE_EQ(hypervolumeOf(loaded.bodies), kSimplex);
  EXPECT_EQ(loaded.dialect, "text, version 1");
  ASSERT_EQ(loaded.losses.size(), 1U);
  EXPECT_TRUE(loaded.losses[0].ends_with("a.mesh: '1' 'Edges' are not read"));
}

TEST(Medit, SaysWhatIsWrong) {
  const std::string head = "MeshVersionFormatted 2\nDimension 4\n";
  EXPECT_EQ(error4dOf("a.mesh", "MeshVersionFormatted 2\nDimension 3\nVertices 0\nEnd\n"),
            "a.mesh:2: is a mesh of dimension 3, expected 4");
  EXPECT_EQ(error4dOf("a.mesh", "MeshVersionFormatted 9\n"),
            "a.mesh:1: is Medit version 9, expected 1 to 4");
  EXPECT_EQ(error4dOf("a.mesh", head + "Vertices 123456789\n0 0 0 0 0\n"),
            "a.mesh:3: the number of vertices is 123456789, which the 11 bytes that follow cannot "
            "hold");
  EXPECT_EQ(error4dOf("a.mesh", head + kMeditSimplex + "Tetrahedra\n1\n2 3 4 6 0\nEnd\n"),
            "a.mesh:12: a tetrahedron refers to vertex 6, but there are 5 vertices, numbered from "
            "1");
  EXPECT_EQ(error4dOf("a.mesh", head + kMeditSimplex + "Tetrahedra\n1\n2 3 0 5 0\nEnd\n"),
            "a.mesh:12: found vertex 0, expected 1 or more");
  EXPECT_EQ(error4dOf("a.mesh", head + kMeditSimplex + "Tetrahedra\n2\n2 3 4 5 0\n"),
            "a.mesh:12: the file ends, expected the number of a vertex");
}

const std::string kMfemVertices =
    "vertices\n6\n4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n0 0 0 -1\n";

TEST(Mfem, BoundaryIsMadeOfPentatopesIfThereIsNone) {
  // Two pentatopes with a common tetrahedron, the second the other way round.
  const LoadedMesh4d loaded =
      read4dBytes("a.mesh",
                  "MFEM mesh v1.0\n\n# geometry types\n\ndimension\n4\n\nelements\n2\n"
                  "1 8 0 1 2 3 4\n1 8 0 1 2 3 5\n\nboundary\n0\n\n" +
                      kMfemVertices);
  ASSERT_EQ(loaded.bodies.size(), 1U);
  EXPECT_EQ(loaded.bodies[0].cells.size(), 8U);
  EXPECT_DOUBLE_EQ(hypervolumeOf(loaded.bodies), 2 * kSimplex);
  EXPECT_EQ(loaded.dialect, "boundary of pentatopes");
  EXPECT_EQ(loaded.losses.size(), 1U);
}

TEST(Mfem, BranchesOfMfemHaveOtherNumbersForPentatopes) {
  for (const char* const geometry : {"6", "7", "8"}) {
    const LoadedMesh4d loaded = read4dBytes(
        "a.mesh",
        fmt::format("MFEM mesh v1.0\ndimension\n4\nelements\n1\n1 {} 0 1 2 3 4\nboundary\n"
                    "0\n{}",
                    geometry, kMfemVertices));
    EXPECT_DOUBLE_EQ(hypervolumeOf(loaded.bodies), kSimplex) << geometry;
  }
}

TEST(Mfem, PentatopesAreNotFlatForBeingSmall) {
  const std::string elements =
      "MFEM mesh v1.0\ndimension\n4\nelements\n2\n1 8 0 1 2 3 4\n1 8 0 1 2 3 5\nboundary\n0\n";
  const auto vertices = [](const std::string& one) {
    return "vertices\n6\n4\n0 0 0 0\n" + one + " 0 0 0\n0 " + one + " 0 0\n0 0 " + one +
           " 0\n0 0 0 " + one + "\n0 0 0 -" + one + "\n";
  };
  const LoadedMesh4d small = read4dBytes("a.mesh", elements + vertices("1e-90"));
  const LoadedMesh4d unit = read4dBytes("a.mesh", elements + vertices("1"));
  ASSERT_EQ(small.bodies.size(), 1U);
  EXPECT_EQ(small.bodies[0].cells, unit.bodies[0].cells);
}

TEST(Mfem, AFileThatEndsAmongItsElementsSaysWhere) {
  EXPECT_THAT(error4dOf("a.mesh", "MFEM mesh v1.0\ndimension\n4\nelements\n2\n1 8 0 1 2 3 4\n"),
              testing::HasSubstr("the file ends after 1 of 2 "));
}

TEST(Mfem, BoundaryIsReadWhereThereIsOne) {
  const LoadedMesh4d loaded =
      read4dBytes("a.mesh",
                  "MFEM mesh v1.0\ndimension\n4\nelements\n1\n1 8 0 1 2 3 4\nboundary\n5\n"
                  "1 4 1 2 3 4\n1 4 2 0 3 4\n1 4 0 1 3 4\n1 4 1 0 2 4\n1 4 0 1 2 3\n" +
                      kMfemVertices);
  EXPECT_DOUBLE_EQ(hypervolumeOf(loaded.bodies), kSimplex);
  EXPECT_EQ(loaded.dialect, "boundary elements");
}

TEST(Mfem, SaysWhatIsWrong) {
  EXPECT_EQ(error4dOf("a.mesh", "MFEM mesh v1.3\n"),
            "a.mesh:1: found 'MFEM mesh v1.3', expected 'MFEM mesh v1.0'");
  EXPECT_EQ(error4dOf("a.mesh", "MFEM mesh v1.0\ndimension\n3\n"),
            "a.mesh:3: is a mesh of dimension 3, expected 4");
  EXPECT_EQ(error4dOf("a.mesh", "MFEM mesh v1.0\ndimension\n4\nelements\n1\n1 5 0 1 2 3 4 5 6 7\n"),
            "a.mesh:6: found geometry 5, expected 6 or 7 or 8 (pentatope)");
  EXPECT_EQ(error4dOf("a.mesh",
                      "MFEM mesh v1.0\ndimension\n4\nelements\n1\n1 8 0 1 2 3 6\n" + kMfemVertices),
            "a.mesh:6: an element refers to vertex 6, but there are 6, numbered from 0");
}

const std::string kGmshNodes =
    "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n2 5 10 50\n0 1 0 1\n10\n0 0 0\n3 1 0 4\n20\n30\n"
    "40\n50\n1 0 0\n0 1 0\n0 0 1\n0 0 0\n$EndNodes\n";
const std::string kGmshElements =
    "$Elements\n2 6 1 6\n2 1 2 1\n1 10 20 30\n3 1 4 5\n2 20 30 40 50\n3 30 10 40 50\n4 10 20 40 "
    "50\n"
    "5 20 10 30 50\n6 10 20 30 40\n$EndElements\n";
const std::string kGmshTime =
    "$NodeData\n1\n\"time\"\n1\n0.0\n3\n0\n1\n5\n10 0\n20 0\n30 0\n40 0\n50 1\n$EndNodeData\n";

TEST(Gmsh, IsReadWithAnyTagsBlocksAndSections) {
  const LoadedMesh4d loaded =
      read4dBytes("a.msh", kGmshNodes + kGmshElements + "$Periodic\n0\n$EndPeriodic\n" + kGmshTime +
                               "$NodeData\n1\n\"speed\"\n0\n0\n$EndNodeData\n");
  ASSERT_EQ(loaded.bodies.size(), 1U);
  EXPECT_DOUBLE_EQ(hypervolumeOf(loaded.bodies), kSimplex);
  EXPECT_EQ(loaded.losses.size(), 1U);
}

TEST(Gmsh, SaysWhatIsWrong) {
  EXPECT_EQ(error4dOf("a.msh", "$MeshFormat\n2.2 0 8\n"),
            "a.msh:2: is MSH version '2.2', expected 4.1; Gmsh writes it with `-format msh41`");
  EXPECT_EQ(error4dOf("a.msh", kGmshNodes + kGmshElements),
            "a.msh: has no $NodeData \"time\", which would be the fourth coordinate");
  EXPECT_EQ(error4dOf("a.msh", kGmshNodes + kGmshElements.substr(0, 30)),
            "a.msh:22: the file ends, expected a block of elements");
  EXPECT_EQ(error4dOf("a.msh", kGmshNodes + kGmshTime.substr(0, 45) + "\n$EndNodeData\n"),
            "a.msh:30: the line ends, expected a time");
  std::string without = kGmshTime;
  without.replace(without.find("5\n10 0\n"), 7, "4\n10 0\n").erase(without.find("30 0\n"), 5);
  EXPECT_EQ(error4dOf("a.msh", kGmshNodes + kGmshElements + without),
            "a.msh:15: node 30 has no time");
  // More nodes than lines can follow, and fewer than bytes do.
  std::string many = kGmshNodes + kGmshElements + kGmshTime;
  many.replace(many.find("3 1 0 4\n"), 8, "3 1 0 100\n");
  EXPECT_NE(error4dOf("a.msh", many).find("declares 100 "), std::string::npos)
      << error4dOf("a.msh", many);
}

const std::string kTetGenNodes =
    "# c\n5 3 1 1\n0 0 0 0 0 9\n1 1 0 0 0 9\n2 0 1 0 0 9\n3 0 0 1 0 9\n4 0 0 0 1 9\n";
const std::string kTetGenElements =
    "5 4 0\n0 1 2 3 4\n1 2 0 3 4\n2 0 1 3 4\n3 1 0 2 4\n4 0 1 2 3\n# Generated\n";

TEST(TetGen, IsReadByEitherOfItsFiles) {
  const auto nodes = writeFile("pair.node", kTetGenNodes);
  const auto elements = writeFile("pair.ele", kTetGenElements);
  for (const auto& path : {nodes, elements}) {
    const auto loaded = read4d(path);
    ASSERT_TRUE(loaded) << loaded.error().text();
    EXPECT_DOUBLE_EQ(hypervolumeOf(loaded->bodies), kSimplex);
    EXPECT_EQ(loaded->otherFiles.size(), 1U);
  }
}

TEST(TetGen, SaysWhatIsWrong) {
  const auto errorOfPair = [](const std::string& nodes, const std::string& elements) {
    writeFile("wrong.ele", elements);
    return error4dOf("wrong.node", nodes);
  };
  EXPECT_EQ(errorOfPair("5 3 0 0\n" + kTetGenNodes, kTetGenElements),
            "wrong.node:1: has points of dimension 3 with 0 attributes, expected 3 and 1: x, y, z "
            "and the time");
  EXPECT_EQ(errorOfPair("2 3 1 0\n1 0 0 0 0\n3 0 0 0 0\n", kTetGenElements),
            "wrong.node:3: found number 3, expected 2");
  EXPECT_EQ(errorOfPair(kTetGenNodes, "1 10 0\n0 1 2 3 4\n"),
            "wrong.ele:1: has elements of 10 nodes, expected 4");
  EXPECT_EQ(errorOfPair(kTetGenNodes, "1 4 0\n0 1 2 3 5\n"),
            "wrong.ele:2: a tetrahedron refers to point 5, but there are 5, numbered from 0");
  EXPECT_EQ(errorOfPair("99999999 3 1 0\n", kTetGenElements),
            "wrong.node:1: the number of points is 99999999, which the 1 bytes that follow cannot "
            "hold");
}

}  // namespace
}  // namespace t4d::formats
