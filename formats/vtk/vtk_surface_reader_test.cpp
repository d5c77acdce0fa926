#include "formats/vtk/vtk_surface_reader.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "formats/animation/mesh_steps.h"
#include "formats/test_files.h"

namespace t4d::formats {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::string textArray(const std::string& attributes, const std::string& values) {
  return "<DataArray " + attributes + " format=\"ascii\">" + values + "</DataArray>\n";
}

std::string vtkText(const std::string& type, const std::string& inside) {
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"" + type + "\">\n<" + type + ">\n" + inside +
         "</" + type + ">\n</VTKFile>\n";
}

std::string pointsText(const std::string& coordinates) {
  return "<Points>\n" + textArray("type=\"Float64\" NumberOfComponents=\"3\"", coordinates) +
         "</Points>\n";
}

std::string cellsText(const std::string& name, const std::string& corners, const std::string& ends,
                      const std::string& more = "") {
  return "<" + name + ">\n" + textArray("type=\"Int64\" Name=\"connectivity\"", corners) +
         textArray("type=\"Int64\" Name=\"offsets\"", ends) + more + "</" + name + ">\n";
}

std::string cubePoints() {
  std::string text;
  for (int i = 0; i < 8; ++i) {
    const model::Point3 p = cubeCorner(i);
    text += fmt::format("{} {} {} ", p.x(), p.y(), p.z());
  }
  return text;
}

std::string squares(int first = 0, int count = 6) {
  std::string text;
  for (int i = first; i < first + count; ++i) {
    for (const int corner : kCubeSquares[i]) text += fmt::format("{} ", corner);
  }
  return text;
}

std::string cubePiece(const std::string& data = "", const std::string& ends = "4 8 12 16 20 24") {
  return "<Piece NumberOfPoints=\"8\" NumberOfPolys=\"6\">\n" + data + pointsText(cubePoints()) +
         cellsText("Polys", squares(), ends) + "</Piece>\n";
}

std::string gridText(const std::string& corners, const std::string& ends,
                     const std::string& types) {
  const auto count = std::ranges::count(types, ' ') + 1;
  return vtkText(
      "UnstructuredGrid",
      fmt::format("<Piece NumberOfPoints=\"8\" NumberOfCells=\"{}\">\n", count) +
          pointsText(cubePoints()) +
          cellsText("Cells", corners, ends, textArray("type=\"UInt8\" Name=\"types\"", types)) +
          "</Piece>\n");
}

const model::Attribute* attributeOf(const LoadedMesh& loaded, std::string_view name) {
  const auto found = std::ranges::find(loaded.mesh.attributes, name, &model::Attribute::name);
  return found == loaded.mesh.attributes.end() ? nullptr : &*found;
}

TEST(Vtp, PiecesBecomeOneMesh) {
  // Half a cube in each piece, as polygons and as a strip.
  const std::string piece =
      vtkText("PolyData",
              "<Piece NumberOfPoints=\"8\" NumberOfPolys=\"5\">\n" + pointsText(cubePoints()) +
                  cellsText("Polys", squares(0, 5), "4 8 12 16 20") +
                  "</Piece>\n<Piece NumberOfPoints=\"8\" NumberOfStrips=\"1\">\n" +
                  pointsText(cubePoints()) + cellsText("Strips", "1 3 5 7", "4") + "</Piece>\n");
  const LoadedMesh loaded = readBytes("a.vtp", piece);
  EXPECT_EQ(loaded.mesh.vertices.size(), 8U);
  EXPECT_TRUE(model::isClosed(loaded.mesh));
  EXPECT_EQ(model::signedVolume(loaded.mesh), 1);
  EXPECT_THAT(loaded.losses, IsEmpty());
}

TEST(Vtp, DataOfPointsAndCellsAreAttributes) {
  const std::string data =
      "<PointData Normals=\"n\" TCoords=\"look\">\n" +
      textArray("type=\"Float32\" Name=\"heat\"", "0 1 2 3 4 5 6 7") +
      textArray("type=\"Float32\" Name=\"n\"", "0 1 2 3 4 5 6 7") +
      textArray("type=\"Float32\" Name=\"look\"", "0 1 2 3 4 5 6 7") +
      textArray("type=\"String\" Name=\"words\"", "0 1 2") + "</PointData>\n<CellData>\n" +
      textArray("type=\"UInt8\" Name=\"side\"", "1 2 3 4 5 6") + "</CellData>\n";
  const std::string bytes = vtkText("PolyData", cubePiece(data));
  const LoadedMesh loaded = readBytes("a.vtp", bytes, Keep::Attributes);
  const model::Attribute* heat = attributeOf(loaded, "heat");
  ASSERT_NE(heat, nullptr);
  EXPECT_EQ(heat->domain, model::Domain::Vertex);
  EXPECT_EQ(loadNumber<float>(reinterpret_cast<const char*>(heat->row(5))), 5);
  const model::Attribute* side = attributeOf(loaded, "side");
  ASSERT_NE(side, nullptr);
  ASSERT_EQ(side->rows(), 12U);
  for (std::size_t i = 0; i < 12; ++i) EXPECT_EQ(int(*side->row(i)), int(1 + i / 2));
  EXPECT_EQ(attributeOf(loaded, "n"), nullptr);
  EXPECT_THAT(loaded.losses, ElementsAre("data that are not read: words"));
  const LoadedMesh shape = readBytes("a.vtp", bytes);
  EXPECT_THAT(shape.mesh.attributes, IsEmpty());
  EXPECT_THAT(shape.losses, ElementsAre("data that are not read: heat, side, words"));
}

TEST(Vtp, GhostCellsAreLeftOut) {
  const std::string data = "<CellData>\n" +
                           textArray("type=\"UInt8\" Name=\"vtkGhostType\"", "0 0 1 0 0 32") +
                           "</CellData>\n";
  const LoadedMesh loaded = readBytes("a.vtp", vtkText("PolyData", cubePiece(data)));
  EXPECT_EQ(loaded.mesh.triangles.size(), 8U);
  EXPECT_THAT(loaded.losses, IsEmpty());
}

TEST(Vtp, SaysWhatIsWrong) {
  const auto errorOfPiece = [](const std::string& piece) {
    return errorOf("a.vtp", vtkText("PolyData", piece));
  };
  EXPECT_EQ(errorOf("a.vtp", "nothing"), "a.vtp:1: is not XML: syntax error");
  EXPECT_EQ(errorOf("a.vtp", vtkText("UnstructuredGrid", "")),
            "a.vtp: is not a VTKFile of type PolyData");
  EXPECT_EQ(errorOf("a.vtp", vtkText("PolyData", "")), "a.vtp: holds no triangles");
  EXPECT_EQ(errorOfPiece("<Piece NumberOfPoints=\"8\">\n<Points>\n" + cubePiece() +
                         textArray("type=\"Float64\"", "0") + "</Points>\n</Piece>\n"),
            "a.vtp: a piece has no Points");
  EXPECT_EQ(errorOfPiece(cubePiece("", "4 8 12 16 20 28")),
            "a.vtp: the array 'connectivity' has fewer than 28 values");
  EXPECT_EQ(errorOfPiece(cubePiece("", "4 8 12 16 24 20")), "a.vtp: the array 'offsets' goes down");
  EXPECT_EQ(errorOfPiece(cubePiece("", "4 8 12 16 20")),
            "a.vtp: the array 'offsets' is wrong: the file ends, expected a number");
  EXPECT_EQ(errorOfPiece(cubePiece("", "2 8 12 16 20 24")),
            "a.vtp: cell 0: a face of 2 corners, expected at least 3");
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string piece = cubePiece();
    piece.replace(piece.find(from), from.size(), to);
    return errorOfPiece(piece);
  };
  EXPECT_EQ(changed("0 2 3 1", "0 2 3 8"),
            "a.vtp: the array 'connectivity' has the number 8, expected 0 to 7");
  EXPECT_EQ(changed("0 2 3 1", "0 2 3 -1"),
            "a.vtp: the array 'connectivity' has the number -1, expected 0 to 7");
  EXPECT_THAT(changed("0 0 0", "0 0 nan"), HasSubstr("expected finite coordinates"));
  EXPECT_THAT(changed("NumberOfPoints=\"8\"", "NumberOfPoints=\"7\""),
              HasSubstr("has more than 21 values"));
  EXPECT_THAT(changed("NumberOfPoints=\"8\"", "NumberOfPoints=\"4000000000\""),
              HasSubstr("has fewer than 12000000000 values"));
  EXPECT_THAT(changed("NumberOfPolys=\"6\"", "NumberOfPolys=\"-1\""),
              HasSubstr("NumberOfPolys is '-1', expected a whole number below 2^32"));
  EXPECT_THAT(changed("NumberOfComponents=\"3\"", "NumberOfComponents=\"2\""),
              HasSubstr("has 2 components, expected 3"));
}

TEST(Vtp, EntitiesThatExpandWithoutEndAreRefused) {
  std::string text = "<?xml version=\"1.0\"?>\n<!DOCTYPE VTKFile [<!ENTITY a0 \"0 0 0 0 0 0 0 0\">";
  for (int i = 1; i < 12; ++i) {
    text += fmt::format("<!ENTITY a{} \"", i);
    for (int k = 0; k < 10; ++k) text += fmt::format("&a{};", i - 1);
    text += "\">";
  }
  text += "]>\n<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"8\">" +
          pointsText("&a11;") + "</Piece></PolyData></VTKFile>";
  EXPECT_THAT(errorOf("a.vtp", text), HasSubstr("is not XML: limit on input amplification"));
}

TEST(VtuSurface, FlatCellsOfAllKindsAreRead) {
  const LoadedMesh loaded =
      readBytes("a.vtu", gridText("0 2 3 1  4 5 6 7  0 1 5 4  2 6 7 3  0 4 6 0 6 2  1 3 5 7  0 1",
                                  "4 8 12 16 19 22 26 28", "9 8 7 9 5 5 6 3"));
  EXPECT_TRUE(model::isClosed(loaded.mesh));
  EXPECT_EQ(model::signedVolume(loaded.mesh), 1);
  EXPECT_THAT(loaded.losses, ElementsAre("1 points and lines are not read"));
}

TEST(VtuSurface, OfVolumeCellsIsTheirBoundary) {
  // The cube as two wedges, one in VTK's order of corners and one in that of other programs.
  const LoadedMesh loaded =
      readBytes("a.vtu", gridText("0 1 2 4 5 6  1 3 2 5 7 6  0 1 5", "6 12 15", "13 13 5"));
  EXPECT_EQ(loaded.mesh.triangles.size(), 12U);
  EXPECT_TRUE(model::isClosed(loaded.mesh));
  EXPECT_EQ(model::signedVolume(loaded.mesh), 1);
  EXPECT_THAT(loaded.notices, ElementsAre("the surface is the boundary of 2 volume cells"));
  EXPECT_THAT(loaded.losses, ElementsAre("1 faces beside the volume cells are not read"));
}

TEST(VtuSurface, SaysWhatIsWrong) {
  EXPECT_EQ(errorOf("a.vtu", gridText("0 1 2", "3", "22")),
            "a.vtu: cell 0: is a cell of VTK's type 22, which is curved or not supported; "
            "ParaView's filter Extract Surface makes a surface that can be saved as .vtp");
  EXPECT_EQ(errorOf("a.vtu", gridText("0 1 2", "3", "10")),
            "a.vtu: cell 0: is a cell of VTK's type 10, with 3 corners, expected 4");
  EXPECT_EQ(errorOf("a.vtu", gridText("0 1 2 4 0 1 2 4", "4 8", "10 10")),
            "a.vtu: its 2 volume cells have no boundary; for a 4D mesh, see t4d convert");
  EXPECT_EQ(errorOf("a.vtu", gridText("0 1 2 4 0 1 2 5 0 1 2 6", "4 8 12", "10 10 10")),
            "a.vtu: cell 0: has a face that it shares with 2 other cells, expected one");
  EXPECT_EQ(errorOf("a.vtu", gridText("0 1", "2", "3")), "a.vtu: holds no triangles");
}

std::string collection(const std::string& sets) { return vtkText("Collection", sets); }

std::string dataSet(const std::string& time, const std::string& part, const std::string& file) {
  return fmt::format("<DataSet timestep=\"{}\" group=\"\" part=\"{}\" file=\"{}\"/>\n", time, part,
                     file);
}

Result<MeshSteps> stepsOf(const std::string& text) {
  return meshSteps(std::vector{writeFile("a.pvd", text)});
}

TEST(Collection, StepsAreInOrderOfTimesAndPartsAreMerged) {
  writeFile("polys.vtp",
            vtkText("PolyData", "<Piece NumberOfPoints=\"8\" NumberOfPolys=\"2\">\n" +
                                    pointsText(cubePoints()) +
                                    cellsText("Polys", squares(0, 2), "4 8") + "</Piece>\n"));
  writeFile("grid.vtu", gridText(squares(2, 4), "4 8 12 16", "9 9 9 9"));
  writeFile("whole.vtp", vtkText("PolyData", cubePiece()));
  const auto steps =
      stepsOf(collection(dataSet("2.5", "1", "grid.vtu") + dataSet("-1e-1", "", "whole.vtp") +
                         dataSet("2.5", "0", "polys.vtp")));
  ASSERT_TRUE(steps) << steps.error().text();
  EXPECT_TRUE(steps->timed);
  ASSERT_EQ(steps->steps.size(), 2U);
  EXPECT_EQ(steps->steps[0].time, -0.1);
  EXPECT_EQ(steps->steps[1].time, 2.5);
  ASSERT_EQ(steps->steps[1].files.size(), 2U);
  EXPECT_EQ(steps->steps[1].files[0].filename(), "polys.vtp");
  const auto merged = readMeshStep(steps->steps[1]);
  ASSERT_TRUE(merged) << merged.error().text();
  EXPECT_EQ(merged->mesh.vertices.size(), 8U);
  EXPECT_TRUE(model::isClosed(merged->mesh));
  EXPECT_EQ(model::signedVolume(merged->mesh), 1);
  EXPECT_EQ(merged->points.vertexOf.size(), 16U);
  EXPECT_EQ(merged->points.faceCount, 6U);
}

TEST(Collection, FilesMayBeNamedAsOnWindows) {
  const auto path = writeFile("whole.vtp", vtkText("PolyData", cubePiece()));
  const auto folder = path.parent_path() / "in" / "here";
  std::filesystem::create_directories(folder);
  std::filesystem::copy_file(path, folder / "b.vtp",
                             std::filesystem::copy_options::overwrite_existing);
  const auto steps =
      stepsOf(collection(dataSet("0", "0", "in\\here\\b.vtp") + dataSet("1", "0", ".\\whole.vtp")));
  ASSERT_TRUE(steps) << steps.error().text();
  ASSERT_EQ(steps->steps.size(), 2U);
  EXPECT_TRUE(std::filesystem::equivalent(steps->steps[0].files[0], folder / "b.vtp"));
  EXPECT_TRUE(std::filesystem::equivalent(steps->steps[1].files[0], path));
  // A name that has a backslash is taken as it is.
  std::filesystem::copy_file(path, path.parent_path() / "in\\c.vtp",
                             std::filesystem::copy_options::overwrite_existing);
  const auto own =
      stepsOf(collection(dataSet("0", "0", "in\\c.vtp") + dataSet("1", "0", "whole.vtp")));
  ASSERT_TRUE(own) << own.error().text();
  EXPECT_EQ(own->steps[0].files[0].filename(), "in\\c.vtp");
  const auto outside =
      stepsOf(collection(dataSet("0", "0", "..\\..\\x.vtp") + dataSet("1", "0", "whole.vtp")));
  ASSERT_FALSE(outside);
  EXPECT_THAT(outside.error().message, HasSubstr("names the file '..\\..\\x.vtp'"));
}

TEST(Collection, SaysWhatIsWrong) {
  const auto path = writeFile("whole.vtp", vtkText("PolyData", cubePiece()));
  const auto problem = [&](const std::string& sets) {
    const auto steps = stepsOf(collection(dataSet("0", "0", "whole.vtp") + sets));
    return steps ? "(was accepted)" : textOf(steps.error(), path);
  };
  EXPECT_EQ(problem(""), "a.pvd: one frame only; a 4D mesh needs two or more");
  EXPECT_EQ(problem(dataSet("", "0", "whole.vtp")),
            "a.pvd:5: the timestep is '', expected a number");
  EXPECT_EQ(problem(dataSet("inf", "0", "whole.vtp")),
            "a.pvd:5: the timestep is 'inf', expected a number");
  EXPECT_EQ(problem(dataSet("1e300", "0", "whole.vtp")),
            "a.pvd:5: the timestep is '1e300'; the largest possible is 1e+70");
  EXPECT_EQ(problem(dataSet("1", "0.5", "whole.vtp")),
            "a.pvd:5: the part is '0.5', expected a whole number");
  EXPECT_EQ(problem(dataSet("1", "0", "none.vtp")),
            "a.pvd:5: names the file 'none.vtp': no such file");
  EXPECT_THAT(problem(dataSet("1", "0", "grid.vtm")), HasSubstr(".vtm is not the extension"));
  const auto outside = path.parent_path().parent_path() / "outside.vtp";
  std::filesystem::copy_file(path, outside, std::filesystem::copy_options::overwrite_existing);
  for (const std::string& name : {std::string("../outside.vtp"), outside.string(),
                                  std::string("../../../../../../etc/passwd")}) {
    EXPECT_EQ(problem(dataSet("1", "0", name)).substr(0, 23), "a.pvd:5: names the file") << name;
  }
  const auto link = path.parent_path() / "link.vtp";
  std::filesystem::remove(link);
  std::filesystem::create_symlink(outside, link);
  EXPECT_EQ(problem(dataSet("1", "0", "link.vtp")).substr(0, 23), "a.pvd:5: names the file");
  std::filesystem::remove(outside);
  EXPECT_EQ(problem("<DataSet timestep=\"1\""),
            "a.pvd:5: is not XML: not well-formed "
            "(invalid token)");
  const auto two = meshSteps(std::vector{path, writeFile("a.pvd", collection(""))});
  ASSERT_FALSE(two);
  EXPECT_EQ(textOf(two.error(), path), "a.pvd: a collection is given alone: it lists the meshes");
}

}  // namespace
}  // namespace t4d::formats
