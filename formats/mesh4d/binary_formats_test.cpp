#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <lz4.h>
#include <lzma.h>
#include <nlohmann/json.hpp>
#include <zstd.h>

#include "formats/mesh4d/test_mesh4d.h"
#include "formats/mesh4d/vtu_writer.h"
#include "formats/packed_block.h"
#include "formats/text/base64.h"
#include "formats/zlib_block.h"
#include "platform/test_folder.h"
#include "t4d/file.h"

/// VTU and G4MF as other programs write them.
namespace t4d::formats {
namespace {

constexpr double kSimplexHypervolume = 1.0 / 24;

std::string vtuText(const std::string& more, const std::string& piece) {
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" " + more +
         ">\n<UnstructuredGrid>\n" + piece + "</UnstructuredGrid>\n";
}

/// An array of numbers as text.
std::string asciiArray(const std::string& attributes, const std::string& numbers) {
  return "<DataArray " + attributes + " format=\"ascii\">\n" + numbers + "\n</DataArray>\n";
}

std::string simplexPiece(const std::string& times = "0 0 0 0 1") {
  return "<Piece NumberOfPoints=\"5\" NumberOfCells=\"5\">\n<PointData>\n" +
         asciiArray("type=\"Float32\" Name=\"t\"", times) + "</PointData>\n<Points>\n" +
         asciiArray("type=\"Float32\" NumberOfComponents=\"3\"",
                    "0 0 0  1 0 0  0 1 0\n0 0 1 0 0 0") +
         "</Points>\n<Cells>\n" +
         asciiArray("type=\"Int64\" Name=\"connectivity\"",
                    "1 2 3 4 2 0 3 4 0 1 3 4 1 0 2 4 0 1 2 3") +
         asciiArray("type=\"Int64\" Name=\"offsets\"", "4 8 12 16 20") +
         asciiArray("type=\"UInt8\" Name=\"types\"", "10 10 10 10 10") + "</Cells>\n</Piece>\n";
}

TEST(Vtu, IsReadAsTextInSeveralPieces) {
  const LoadedMesh4d loaded = read4dBytes(
      "a.vtu", vtuText("byte_order=\"LittleEndian\"", simplexPiece() + simplexPiece("5 5 5 5 7")) +
                   "</VTKFile>\n");
  ASSERT_EQ(loaded.bodies.size(), 1U);
  EXPECT_DOUBLE_EQ(hypervolumeOf(loaded.bodies), 3 * kSimplexHypervolume);
  EXPECT_EQ(loaded.dialect, "ASCII");
  EXPECT_TRUE(loaded.losses.empty());
}

TEST(Vtu, NumbersOfTextAreOfTheTypeOfTheirArray) {
  std::string wide;
  for (int i = 0; i < 5 * 255; ++i) wide += "1 ";
  std::string piece = simplexPiece();
  piece.insert(piece.find("<PointData>") + 11,
               asciiArray("type=\"UInt64\" Name=\"largest\"", "18446744073709551615 0 1 2 3") +
                   asciiArray("type=\"UInt8\" Name=\"large\"", "256 0 1 2 3") +
                   asciiArray("type=\"UInt16\" Name=\"negative\"", "-1 0 1 2 3") +
                   asciiArray("type=\"Float32\" Name=\"nan\"", "nan -inf 1 2 3") +
                   asciiArray("type=\"Int8\" Name=\"wide\" NumberOfComponents=\"255\"", wide));
  const LoadedMesh4d loaded = read4dBytes("a.vtu", vtuText("", piece) + "</VTKFile>\n");
  std::vector<std::string> names;
  for (const model::Attribute& attribute : loaded.bodies[0].attributes) {
    names.push_back(attribute.name);
  }
  EXPECT_THAT(names, testing::ElementsAre("largest", "nan", "wide"));
  ASSERT_EQ(loaded.losses.size(), 1U);
  EXPECT_THAT(loaded.losses[0], testing::HasSubstr("not read: large, negative"));
  std::uint64_t first = 0;
  std::memcpy(&first, loaded.bodies[0].attributes[0].row(0), sizeof first);
  EXPECT_EQ(first, 18446744073709551615U);
}

TEST(Vtu, CellsOfOtherShapesAreSplit) {
  // The cubes of a tesseract, in the order of VTK's hexahedra and voxels.
  const fixtures::Polytope polytope = fixtures::tesseract();
  for (const bool voxels : {false, true}) {
    std::string points;
    std::string times;
    for (const model::Point4& v : polytope.vertices) {
      points += fmt::format("{} {} {} ", v[0], v[1], v[2]);
      times += fmt::format("{} ", v[3]);
    }
    std::string corners;
    for (int axis = 0; axis < 4; ++axis) {
      for (const double side : {-1.0, 1.0}) {
        std::vector<int> others;
        for (int i = 0; i < 4; ++i) {
          if (i != axis) others.push_back(i);
        }
        for (int k = 0; k < 8; ++k) {
          // Voxels count in binary, hexahedra go around each square.
          const int code = voxels ? k : k ^ (k >> 1 & 1);
          model::Point4 corner = side * model::Point4::Unit(axis);
          for (int i = 0; i < 3; ++i) corner[others[i]] = (code >> i & 1) != 0 ? 1 : -1;
          const auto at = std::ranges::find(polytope.vertices, corner);
          corners += fmt::format("{} ", at - polytope.vertices.begin());
        }
      }
    }
    const std::string type = voxels ? "11" : "12";
    LoadedMesh4d loaded = read4dBytes(
        "cubes.vtu",
        vtuText("", "<Piece NumberOfPoints=\"16\" NumberOfCells=\"9\">\n<PointData>\n" +
                        asciiArray("type=\"Float64\" Name=\"time\"", times) +
                        asciiArray("type=\"Float64\" Name=\"heat\"", times) +
                        "</PointData>\n<Points>\n" +
                        asciiArray("type=\"Float64\" NumberOfComponents=\"3\"", points) +
                        "</Points>\n<Cells>\n" +
                        asciiArray("type=\"Int32\" Name=\"connectivity\"", corners + "0 1 2") +
                        asciiArray("type=\"Int32\" Name=\"offsets\"", "8 16 24 32 40 48 56 64 67") +
                        asciiArray("type=\"UInt8\" Name=\"types\"",
                                   fmt::format("{}", fmt::join(std::vector(8, type), " ")) + " 5") +
                        "</Cells>\n</Piece>\n") +
            "</VTKFile>\n");
    ASSERT_EQ(loaded.bodies.size(), 1U);
    turnOutward(loaded.bodies[0]);
    EXPECT_NEAR(hypervolumeOf(loaded.bodies), 16, 1e-12);
    EXPECT_EQ(loaded.notices.size(), 1U);
    EXPECT_EQ(loaded.losses.size(), 1U);  // the triangle
    ASSERT_EQ(loaded.bodies[0].attributes.size(), 1U);
    const model::Attribute& heat = loaded.bodies[0].attributes[0];
    EXPECT_EQ(heat.name, "heat");
    for (std::size_t i = 0; i < heat.rows(); ++i) {
      double value = 0;
      std::memcpy(&value, heat.row(i), sizeof value);
      EXPECT_EQ(value, loaded.bodies[0].vertices[i][3]);
    }
  }
}

/// VTU with cells of these types.
std::string cellsText(const std::vector<model::Point4>& vertices,
                      const std::vector<std::vector<int>>& cells, const std::string& types) {
  std::string points;
  std::string times;
  for (const model::Point4& v : vertices) {
    points += fmt::format("{} {} {} ", v[0], v[1], v[2]);
    times += fmt::format("{} ", v[3]);
  }
  std::string corners;
  std::string offsets;
  std::size_t end = 0;
  for (const std::vector<int>& cell : cells) {
    corners += fmt::format("{} ", fmt::join(cell, " "));
    offsets += fmt::format("{} ", end += cell.size());
  }
  return vtuText("", fmt::format("<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
                                 vertices.size(), cells.size()) +
                         "<PointData>\n" + asciiArray("type=\"Float64\" Name=\"t\"", times) +
                         "</PointData>\n<Points>\n" +
                         asciiArray("type=\"Float64\" NumberOfComponents=\"3\"", points) +
                         "</Points>\n<Cells>\n" +
                         asciiArray("type=\"Int32\" Name=\"connectivity\"", corners) +
                         asciiArray("type=\"Int32\" Name=\"offsets\"", offsets) +
                         asciiArray("type=\"UInt8\" Name=\"types\"", types) +
                         "</Cells>\n</Piece>\n") +
         "</VTKFile>\n";
}

TEST(Vtu, PyramidsAndWedgesCloseASolidWithHexahedra) {
  // A pyramid over a cube: the cube, and a pyramid over each of its sides.
  std::vector<model::Point4> vertices;
  for (int k = 0; k < 8; ++k) {
    const int code = k ^ (k >> 1 & 1);  // hexahedra go around each square
    vertices.emplace_back(code & 1, code >> 1 & 1, code >> 2 & 1, 0);
  }
  vertices.emplace_back(0.25, 0.5, 0.75, 2);
  const std::vector<std::vector<int>> sides = {{0, 1, 2, 3}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                               {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  std::vector<std::vector<int>> cells = {{0, 1, 2, 3, 4, 5, 6, 7}};
  for (std::vector<int> side : sides) {
    side.push_back(8);
    cells.push_back(side);
  }
  // Any numbering works: cells are pulled from the smallest vertex.
  const auto expectHypervolume = [&](const std::string& types, double expected) {
    const int count = static_cast<int>(vertices.size());
    for (int shift = 0; shift < count; ++shift) {
      std::vector<model::Point4> shifted(vertices.size());
      for (int i = 0; i < count; ++i) shifted[(i + shift) % count] = vertices[i];
      auto renumbered = cells;
      for (std::vector<int>& cell : renumbered) {
        for (int& corner : cell) corner = (corner + shift) % count;
      }
      LoadedMesh4d loaded = read4dBytes("a.vtu", cellsText(shifted, renumbered, types));
      ASSERT_EQ(loaded.bodies.size(), 1U);
      turnOutward(loaded.bodies[0]);
      EXPECT_NEAR(hypervolumeOf(loaded.bodies), expected, 1e-12) << shift;
    }
  };
  expectHypervolume("12 14 14 14 14 14 14", 2.0 / 4);

  // A triangle times a square: a wedge for each side of the square, a hexahedron for each of the
  // triangle.
  vertices.clear();
  for (int triangle = 0; triangle < 3; ++triangle) {
    for (int square = 0; square < 4; ++square) {
      vertices.emplace_back(triangle == 1, triangle == 2, square == 1 || square == 2, square / 2);
    }
  }
  const auto at = [](int triangle, int square) { return 4 * (triangle % 3) + square % 4; };
  cells.clear();
  for (int s = 0; s < 4; ++s) {
    cells.push_back({at(0, s), at(1, s), at(2, s), at(0, s + 1), at(1, s + 1), at(2, s + 1)});
  }
  for (int t = 0; t < 3; ++t) {
    cells.push_back({at(t, 0), at(t, 1), at(t, 2), at(t, 3), at(t + 1, 0), at(t + 1, 1),
                     at(t + 1, 2), at(t + 1, 3)});
  }
  expectHypervolume("13 13 13 13 12 12 12", 0.5);
}

TEST(Vtu, NumbersOfEachTypeAreReadFromBinaryArrays) {
  const auto readsBack = [](const std::string& type, auto example) {
    using Number = decltype(example);
    std::vector<Number> numbers;
    for (int i = 0; i < 5; ++i)
      numbers.push_back(static_cast<Number>(example - static_cast<Number>(i)));
    std::string bytes(4 + sizeof(Number) * 5, '\0');
    const std::uint32_t size = sizeof(Number) * 5;
    std::memcpy(bytes.data(), &size, sizeof size);
    std::memcpy(bytes.data() + 4, numbers.data(), size);
    std::string piece = simplexPiece();
    piece.insert(piece.find("<PointData>") + 11,
                 "<DataArray type=\"" + type + "\" Name=\"a\" format=\"binary\">\n" +
                     base64({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}) +
                     "\n</DataArray>\n");
    const LoadedMesh4d loaded =
        read4dBytes("a.vtu", vtuText("byte_order=\"LittleEndian\"", piece) + "</VTKFile>\n");
    ASSERT_EQ(loaded.bodies.size(), 1U) << type;
    ASSERT_EQ(loaded.bodies[0].attributes.size(), 1U) << type;
    for (std::size_t i = 0; i < 5; ++i) {
      Number found{};
      std::memcpy(&found, loaded.bodies[0].attributes[0].row(i), sizeof found);
      EXPECT_EQ(found, numbers[i]) << type;
    }
  };
  readsBack("Float64", 1e300);
  readsBack("Float32", 1e30F);
  readsBack("Int64", std::int64_t{-1} << 60);
  readsBack("UInt64", ~std::uint64_t{0});
  readsBack("Int32", std::int32_t{-2000000000});
  readsBack("UInt32", ~std::uint32_t{0});
  readsBack("Int16", std::int16_t{-30000});
  readsBack("UInt16", std::uint16_t{65535});
  readsBack("Int8", std::int8_t{-100});
  readsBack("UInt8", std::uint8_t{255});
}

TEST(G4mf, ABinaryFileHasTheSizeThatItDeclares) {
  std::string file = "G4MF" + std::string(60, '\0');
  file[8] = 63;
  EXPECT_THAT(error4dOf("a.g4b", file), testing::HasSubstr("declares 63 bytes; the file has 64"));
}

/// A 16-cell moved by `offset` along x, with an attribute of each domain.
model::Mesh sixteenCell(double offset) {
  const fixtures::Polytope polytope = fixtures::cell16();
  auto connectivity = std::make_shared<model::Connectivity>();
  connectivity->cells = fixtures::tetrahedra(polytope);
  connectivity->vertexCount = static_cast<std::uint32_t>(polytope.vertices.size());
  std::vector<std::int16_t> numbers;
  for (std::size_t i = 0; i < connectivity->cells.size(); ++i) {
    numbers.push_back(static_cast<std::int16_t>(1000 - 7 * i));
  }
  connectivity->cellAttributes = {model::makeAttribute("n<&\"", model::Domain::Cell, numbers)};
  model::Slab slab{-1, 1, polytope.vertices, connectivity, {}};
  std::vector<double> heights;
  for (model::Point4& vertex : slab.vertices) {
    vertex[0] += offset;
    for (int k = 0; k < 3; ++k) heights.push_back(vertex[0] / 3 + k);
  }
  model::Attribute vectors = model::makeAttribute("u", model::Domain::Vertex, heights);
  vectors.components = 3;
  slab.attributes = {vectors};
  model::Mesh mesh;
  EXPECT_TRUE(mesh.put(slab));
  return mesh;
}

TEST(Vtu, KeepsAttributesAndNamesOfOneBodyAndOfSeveral) {
  for (const std::size_t count : {1U, 2U}) {
    std::vector<model::Mesh> meshes;
    for (std::size_t i = 0; i < count; ++i) meshes.push_back(sixteenCell(10.0 * double(i)));
    std::vector<CountedBody> bodies;
    for (std::size_t i = 0; i < count; ++i) {
      bodies.push_back({{fmt::format("K\u00f6rper {}", i), &meshes[i]}, 8, 16});
    }
    auto flat = FlatBodies::of(bodies);
    ASSERT_TRUE(flat);
    ASSERT_TRUE(flat->findAttributes(keptInVtu));
    const platform::TestFolder folder;
    const auto path = folder / "kept.vtu";
    const auto written = writeVtu(path, *flat);
    ASSERT_TRUE(written) << written.error().text();
    const Mesh4dFormat* format = nullptr;
    const auto loaded = readMesh4d(path, nullptr, format);
    ASSERT_TRUE(loaded) << loaded.error().text();
    EXPECT_TRUE(loaded->losses.empty());
    ASSERT_EQ(loaded->bodies.size(), count);
    for (std::size_t i = 0; i < count; ++i) {
      const Mesh4d& body = loaded->bodies[i];
      const model::Slab& slab = meshes[i].slabs()[0];
      EXPECT_EQ(body.name, bodies[i].name);
      EXPECT_EQ(body.cells, slab.connectivity->cells);
      EXPECT_EQ(body.vertices, slab.vertices);
      EXPECT_EQ(body.attributes, (std::vector<model::Attribute>{
                                     slab.attributes[0], slab.connectivity->cellAttributes[0]}));
    }
  }
}

TEST(Vtu, SaysWhatIsWrong) {
  const auto errorOfPiece = [](const std::string& piece, const std::string& more = "") {
    return error4dOf("a.vtu", vtuText(more, piece) + "</VTKFile>\n");
  };
  EXPECT_EQ(error4dOf("a.vtu", "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\">\n</VTKFile>"),
            "a.vtu: is not a 4D mesh: a .vtu file would begin with XML with `VTKFile` of an "
            "`UnstructuredGrid` (VTK unstructured grid, the time as point data)");
  EXPECT_EQ(error4dOf("a.vtu", "<VTKFile type=\"UnstructuredGrid\">\n<Piece\n</VTKFile>"),
            "a.vtu:3: is not XML: not well-formed (invalid token)");
  EXPECT_EQ(errorOfPiece(simplexPiece(), "byte_order=\"Middle\""),
            "a.vtu:2: found byte_order 'Middle', expected 'LittleEndian' or 'BigEndian'");
  EXPECT_EQ(errorOfPiece(simplexPiece(), "compressor=\"vtkBlosc\""),
            "a.vtu:2: is compressed by 'vtkBlosc', expected vtkZLibDataCompressor, "
            "vtkLZ4DataCompressor or vtkLZMADataCompressor");
  EXPECT_EQ(errorOfPiece(simplexPiece("0 0 0 0")),
            "a.vtu: the array 't' is wrong: the file ends, expected a number");
  EXPECT_EQ(errorOfPiece(simplexPiece("0 0 0 0 1 2")),
            "a.vtu: the array 't' has more than 5 values");
  EXPECT_EQ(errorOfPiece(simplexPiece("0 0 0 0 nan")),
            "a.vtu: element 4: a coordinate is not finite");
  std::string untimed = simplexPiece();
  untimed.replace(untimed.find("\"t\""), 3, "\"u\"");
  EXPECT_EQ(errorOfPiece(untimed),
            "a.vtu: has no point data 't', which would be the fourth coordinate; a surface is an "
            "input of sweep and weave");
  std::string beyond = simplexPiece();
  beyond.replace(beyond.find("1 2 3 4"), 7, "1 2 3 5");
  EXPECT_EQ(errorOfPiece(beyond),
            "a.vtu: the array 'connectivity' has the number 5, expected 0 to 4");
  std::string curved = simplexPiece();
  curved.replace(curved.find("10 10"), 5, "24 10");
  EXPECT_EQ(errorOfPiece(curved),
            "a.vtu: cell 0 has the type 24, which is not supported; tetrahedra (10) are");
  EXPECT_EQ(errorOfPiece("<Piece NumberOfPoints=\"4000000000\" NumberOfCells=\"1\"><PointData>" +
                         asciiArray("type=\"Float32\" Name=\"t\"", "1") + "</PointData><Points>" +
                         asciiArray("type=\"Float32\" NumberOfComponents=\"3\"", "1") +
                         "</Points></Piece>"),
            "a.vtu: the array '' has fewer than 12000000000 values");
}

TEST(Vtu, ABlockThatUnpacksToMoreThanItCanIsRefused) {
  // 2^40 bytes in one block of 20.
  const std::string head = bytesOf(std::uint64_t{1}) + bytesOf(std::uint64_t{1} << 31) +
                           bytesOf(std::uint64_t{0}) + bytesOf(std::uint64_t{20});
  const std::string text =
      vtuText(
          "header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\"",
          "<Piece NumberOfPoints=\"268435456\" NumberOfCells=\"0\"><PointData>"
          "<DataArray type=\"Float64\" Name=\"t\" format=\"appended\" offset=\"0\"/></PointData>"
          "<Points><DataArray type=\"UInt8\" Name=\"p\" NumberOfComponents=\"3\" "
          "format=\"appended\" offset=\"0\"/></Points></Piece>") +
      "<AppendedData encoding=\"raw\">_" + head + std::string(20, 'x') +
      "</AppendedData></VTKFile>";
  EXPECT_EQ(error4dOf("bomb.vtu", text),
            "bomb.vtu: the array 'p' has 1 blocks of 2147483648 bytes, the last of 2147483648, "
            "expected 805306368 bytes");
}

std::string packedWith(Compressor compressor, std::string bytes) {
  if (compressor == Compressor::Zlib) return zlibCompressed(bytes);
  std::string packed(bytes.size() + 4096, '\0');
  if (compressor == Compressor::Lz4) {
    const int size =
        LZ4_compress_default(bytes.data(), packed.data(), static_cast<int>(bytes.size()),
                             static_cast<int>(packed.size()));
    return packed.substr(0, static_cast<std::size_t>(size));
  }
  std::size_t size = 0;
  EXPECT_EQ(lzma_easy_buffer_encode(
                5, LZMA_CHECK_CRC32, nullptr, reinterpret_cast<std::uint8_t*>(bytes.data()),
                bytes.size(), reinterpret_cast<std::uint8_t*>(packed.data()), &size, packed.size()),
            LZMA_OK);
  return packed.substr(0, size);
}

TEST(Vtu, ArraysThatUnpackToFarMoreThanTheFileAreRefused) {
  // 800 MB of zeros, which LZMA makes 120 kB of: a thousand to one is the most.
  const std::string packed = packedWith(Compressor::Lzma, std::string(std::size_t{1} << 22, '\0'));
  constexpr std::uint64_t kBlocks = 192;
  std::string head = bytesOf(kBlocks) + bytesOf(std::uint64_t{1} << 22) + bytesOf(std::uint64_t{0});
  std::string data;
  for (std::uint64_t i = 0; i < kBlocks; ++i) {
    head += bytesOf(std::uint64_t{packed.size()});
    data += packed;
  }
  const std::string text =
      vtuText(
          "header_type=\"UInt64\" compressor=\"vtkLZMADataCompressor\"",
          "<Piece NumberOfPoints=\"33554432\" NumberOfCells=\"0\"><PointData>"
          "<DataArray type=\"Float64\" Name=\"t\" format=\"appended\" offset=\"0\"/></PointData>"
          "<Points><DataArray type=\"Float64\" Name=\"p\" NumberOfComponents=\"3\" "
          "format=\"appended\" offset=\"0\"/></Points></Piece>") +
      "<AppendedData encoding=\"raw\">_" + head + data + "</AppendedData></VTKFile>";
  EXPECT_THAT(
      error4dOf("bomb.vtu", text),
      testing::HasSubstr("bomb.vtu: the array 'p' would make 805306368 bytes of a file of"));
}

TEST(PackedBlock, GivesItsBytesBackAndRefusesOthers) {
  std::string bytes;
  for (unsigned i = 0; i < 100000; ++i) bytes += static_cast<char>(i * i >> 3);
  for (const Compressor compressor : {Compressor::Zlib, Compressor::Lz4, Compressor::Lzma}) {
    for (const std::size_t size :
         {std::size_t{0}, std::size_t{1}, std::size_t{1000}, bytes.size()}) {
      SCOPED_TRACE(fmt::format("{}, {}", nameOf(compressor), size));
      const std::string packed = packedWith(compressor, bytes.substr(0, size));
      std::string back(size, '?');
      ASSERT_TRUE(unpackBlock(compressor, packed, back));
      EXPECT_EQ(back, bytes.substr(0, size));
      std::string longer(size + 1, '?');
      EXPECT_FALSE(unpackBlock(compressor, packed, longer));
      if (size == 0) continue;
      std::string shorter(size - 1, '?');
      EXPECT_FALSE(unpackBlock(compressor, packed, shorter));
      EXPECT_FALSE(unpackBlock(compressor, packed.substr(0, packed.size() - 1), back));
      if (compressor == Compressor::Lz4) continue;
      std::string wrong = packed;
      // The checksum, of zlib at the end, of LZMA before an index of 8 bytes and the footer.
      char& changed = wrong[compressor == Compressor::Zlib ? wrong.size() - 1 : wrong.size() - 21];
      changed = static_cast<char>(changed ^ 1);
      EXPECT_FALSE(unpackBlock(compressor, wrong, back));
    }
  }
}

TEST(PackedBlock, UnpacksToAtMostItsRatio) {
  // A text of zeros: nothing else compresses better.
  const std::string zeros(std::size_t{1} << 26, '\0');
  for (const Compressor compressor : {Compressor::Zlib, Compressor::Lz4, Compressor::Lzma}) {
    const std::size_t ratio = zeros.size() / packedWith(compressor, zeros).size();
    EXPECT_LE(ratio, mostRatio(compressor)) << nameOf(compressor);
    EXPECT_GE(ratio, mostRatio(compressor) / 2) << nameOf(compressor);
  }
}

TEST(PackedBlock, ThatAsksForMoreMemoryThanItsDataIsRefused) {
  std::string packed = packedWith(Compressor::Lzma, "abc");
  std::string back(3, '?');
  ASSERT_TRUE(unpackBlock(Compressor::Lzma, packed, back));
  // The header of the block: its size, flags, sizes, the filter with its properties, a checksum.
  constexpr std::size_t kHeader = 12;
  const std::size_t checked = 4 * std::size_t{static_cast<unsigned char>(packed[kHeader])};
  const std::size_t filter = packed.find("\x21\x01", kHeader);
  ASSERT_LT(filter, kHeader + checked);
  const auto withDictionary = [&](char code) {
    packed[filter + 2] = code;
    const auto* header = reinterpret_cast<const std::uint8_t*>(packed.data()) + kHeader;
    return packed.replace(kHeader + checked, 4, bytesOf(lzma_crc32(header, checked, 0)));
  };
  EXPECT_TRUE(unpackBlock(Compressor::Lzma, withDictionary(28), back));   // 64 MiB
  EXPECT_FALSE(unpackBlock(Compressor::Lzma, withDictionary(40), back));  // 4 GiB
}

/// Numbers of 32 bits from the last byte to the first.
std::string bigEndian(std::vector<std::uint32_t> numbers) {
  std::string bytes;
  for (const std::uint32_t number : numbers) {
    for (int i = 3; i >= 0; --i) bytes += static_cast<char>(number >> (8 * i) & 255);
  }
  return bytes;
}

TEST(Vtu, BigEndianSizesAndNumbersAreRead) {
  std::string piece = simplexPiece();
  const auto from = piece.find(asciiArray("type=\"Float32\" Name=\"t\"", "0 0 0 0 1"));
  ASSERT_NE(from, piece.npos);
  const std::string bytes = bigEndian({20, 0, 0, 0, 0, 0x3f800000});
  const std::string text =
      base64({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  piece.replace(
      from, asciiArray("type=\"Float32\" Name=\"t\"", "0 0 0 0 1").size(),
      "<DataArray type=\"Float32\" Name=\"t\" format=\"binary\">" + text + "</DataArray>\n");
  const LoadedMesh4d loaded =
      read4dBytes("a.vtu", vtuText("byte_order=\"BigEndian\"", piece) + "</VTKFile>\n");
  EXPECT_DOUBLE_EQ(hypervolumeOf(loaded.bodies), kSimplexHypervolume);
  EXPECT_EQ(error4dOf("a.vtu", vtuText("byte_order=\"LittleEndian\"", piece) + "</VTKFile>\n"),
            "a.vtu: the array 't' has 335544320 bytes, expected 20");
}

std::string dataUri(const std::string& bytes) {
  return "\"data:application/octet-stream;base64," +
         base64({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}) + "\"";
}

/// Vertices of a simplex as float32, and its tetrahedra as uint8.
std::string simplexData() {
  std::string data;
  for (int vertex = 0; vertex < 5; ++vertex) {
    for (int i = 0; i < 4; ++i) data += bytesOf(vertex == i + 1 ? 1.0F : 0.0F);
  }
  for (const int corner : {1, 2, 3, 4, 2, 0, 3, 4, 0, 1, 3, 4, 1, 0, 2, 4, 0, 1, 2, 3}) {
    data += static_cast<char>(corner);
  }
  return data;
}

/// A document with this buffer, these meshes and nodes.
std::string g4mfText(const std::string& buffer, const std::string& meshes,
                     const std::string& nodes = "") {
  return R"({"asset":{"dimension":4},"buffers":[)" + buffer +
         R"(],"bufferViews":[{"buffer":0,"byteLength":80},{"byteLength":20,"byteOffset":80}],)"
         R"("accessors":[{"bufferView":0,"primitiveType":"float32","vectorSize":4},)"
         R"({"bufferView":1,"componentType":"uint8","vectorSize":4}],"meshes":)" +
         meshes + nodes + "}";
}

const std::string kMeshes = R"([{"vertices":0,"surfaces":[{"simplexes":1}]}])";
const std::string kOlderMeshes =
    R"([{"surfaces":[{"vertices":0,"cells":1,"polytopeCells":false}]}])";

TEST(G4mf, IsReadWithOlderKeysAndAnyPlacement) {
  const std::string buffer = R"({"byteLength":100,"uri":)" + dataUri(simplexData()) + "}";
  for (const std::string& meshes : {kMeshes, kOlderMeshes}) {
    const LoadedMesh4d plain = read4dBytes("a.g4tf", g4mfText(buffer, meshes));
    EXPECT_DOUBLE_EQ(hypervolumeOf(plain.bodies), kSimplexHypervolume);
    // Two instances: one scaled and moved below a node that is, too; one mirrored.
    const LoadedMesh4d placed = read4dBytes(
        "a.g4tf",
        g4mfText(
            buffer, meshes,
            R"(,"materials":[{}],"nodes":[{"children":[1,3]},{"position":[1,2,3,4],"scale":[2],)"
            R"("children":[2]},{"name":"small","meshInstance":{"mesh":0},"position":[0,0,0,1],)"
            R"("scale":[1,1,1,3]},{"mesh":0,"basis":[-1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}])"));
    ASSERT_EQ(placed.bodies.size(), 2U);
    EXPECT_EQ(placed.bodies[0].name, "small");
    EXPECT_EQ(placed.bodies[0].vertices[0], model::Point4(1, 2, 3, 6));
    EXPECT_EQ(placed.bodies[0].vertices[4], model::Point4(1, 2, 3, 12));
    EXPECT_DOUBLE_EQ(hypervolumeOf({placed.bodies[0]}), 48 * kSimplexHypervolume);
    EXPECT_DOUBLE_EQ(hypervolumeOf({placed.bodies[1]}), kSimplexHypervolume);
    EXPECT_EQ(placed.losses.size(), 1U);
  }
}

/// A 16-cell, whose blend shape moves the vertex (1, 0, 0, 0) by (0.5, 0, 0, 0): of its hypervolume
/// of 2/3, the half on that side grows by half. Vertices (128 bytes), tetrahedra (64), an index
/// (1), an offset from byte 208.
std::string sixteenCell(const std::string& blend, const std::string& instance = "") {
  std::string data;
  for (int vertex = 0; vertex < 8; ++vertex) {
    for (int i = 0; i < 4; ++i) {
      data += bytesOf(i != vertex / 2 ? 0.0F : vertex % 2 == 0 ? -1.0F : 1.0F);
    }
  }
  for (int signs = 0; signs < 16; ++signs) {
    const bool odd = std::popcount(static_cast<unsigned>(signs)) % 2 != 0;
    std::array<int, 4> corners{};
    for (int i = 0; i < 4; ++i) {
      corners[static_cast<std::size_t>(i)] = 2 * i + (signs >> i & 1);
    }
    if (odd) std::swap(corners[2], corners[3]);
    for (const int corner : corners) data += static_cast<char>(corner);
  }
  data += std::string(1, '\1') + std::string(15, '\0');
  for (const float x : {0.5F, 0.0F, 0.0F, 0.0F}) data += bytesOf(x);
  return R"({"asset":{"dimension":4},"buffers":[{"byteLength":224,"uri":)" + dataUri(data) +
         R"(}],"bufferViews":[{"byteLength":128},{"byteLength":64,"byteOffset":128},)"
         R"({"byteLength":1,"byteOffset":192},{"byteLength":16,"byteOffset":208}],"accessors":[)"
         R"({"bufferView":0,"componentType":"float32","vectorSize":4},)"
         R"({"bufferView":1,"componentType":"uint8","vectorSize":4},)"
         R"({"bufferView":2,"componentType":"uint8"},)"
         R"({"bufferView":3,"componentType":"float32","vectorSize":4}],"meshes":[)"
         R"({"vertices":0,"surfaces":[{"simplexes":1}])" +
         blend + R"(}],"nodes":[{"meshInstance":{"mesh":0)" + instance + "}}]}";
}

constexpr const char* kShapes = R"("shapes":[{"position":{"indices":2,"offsets":3}}])";

TEST(G4mf, BlendShapesMoveVerticesByTheirAmounts) {
  const auto hypervolume = [](const std::string& amounts, const std::string& instance = "") {
    const LoadedMesh4d loaded = read4dBytes(
        "a.g4tf", sixteenCell(fmt::format(R"(,"blend":{{{}{}}})", amounts, kShapes), instance));
    EXPECT_TRUE(loaded.losses.empty());
    return hypervolumeOf(loaded.bodies);
  };
  const double whole = 2.0 / 3;
  EXPECT_DOUBLE_EQ(hypervolume(""), whole);
  EXPECT_DOUBLE_EQ(hypervolume(R"("amounts":[1],)"), whole * 1.25);
  EXPECT_DOUBLE_EQ(hypervolume(R"("amounts":[-0.5],)"), whole * 0.875);
  // An instance may have amounts of its own.
  EXPECT_DOUBLE_EQ(hypervolume(R"("amounts":[1],)", R"(,"blendAmounts":[2])"), whole * 1.5);
  EXPECT_DOUBLE_EQ(hypervolume(R"("amounts":[1],)", R"(,"blendAmounts":[0])"), whole);
}

TEST(G4mf, BlendShapesThatDoNotFitAreRefused) {
  const auto problem = [](const std::string& blend) {
    return error4dOf("a.g4tf", sixteenCell(R"(,"blend":)" + blend));
  };
  EXPECT_EQ(problem(fmt::format(R"({{"amounts":[1,2],{}}})", kShapes)),
            "a.g4tf: the amounts of the blend shapes of mesh 0 are not 1 number");
  EXPECT_EQ(problem(R"({"amounts":[1],"shapes":[{"position":{"indices":2,"offsets":1}}]})"),
            "a.g4tf: blend shape 0 of mesh 0 has 1 indices and 16 offsets");
  EXPECT_EQ(problem(R"({"amounts":[1],"shapes":[{"position":{"indices":3,"offsets":3}}]})"),
            "a.g4tf: accessor 3 has a 'vectorSize' of 4, expected 1");
  EXPECT_EQ(problem(R"({"amounts":[1],"shapes":[{"position":{"indices":2}}]})"),
            "a.g4tf: blend shape 0 of mesh 0 lacks indices or offsets");
}

/// A polytope as vertices, edges, faces that list edges, and cells that list faces.
std::string g4mfGeometry(const fixtures::Polytope& polytope) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint16_t> edges;
  std::array<std::string, 4> data;  // vertices, edges, faces, cells
  const auto addNumber = [](std::string& to, std::size_t number) {
    to += bytesOf(static_cast<std::uint16_t>(number));
  };
  for (const model::Point4& vertex : polytope.vertices) {
    for (const double coordinate : vertex) data[0] += bytesOf(coordinate);
  }
  for (const auto& face : polytope.faces) {
    addNumber(data[2], face.size());
    for (std::size_t i = 0; i < face.size(); ++i) {
      const auto ends = std::minmax(face[i], face[(i + 1) % face.size()]);
      const auto [edge, isNew] = edges.emplace(ends, edges.size());
      addNumber(data[2], edge->second);
      if (!isNew) continue;
      addNumber(data[1], ends.first);
      addNumber(data[1], ends.second);
    }
  }
  for (const auto& cell : polytope.cells) {
    addNumber(data[3], cell.size());
    for (const std::uint32_t face : cell) addNumber(data[3], face);
  }
  std::string views;
  std::string all;
  for (const std::string& one : data) {
    views += fmt::format(R"({}{{"byteLength":{},"byteOffset":{}}})", views.empty() ? "" : ",",
                         one.size(), all.size());
    all += one;
  }
  return fmt::format(R"({{"asset":{{"dimension":4}},"buffers":[{{"byteLength":{},"uri":{}}}],)"
                     R"("bufferViews":[{}],"accessors":[)"
                     R"({{"bufferView":0,"componentType":"float64","vectorSize":4}},)"
                     R"({{"bufferView":1,"componentType":"uint16","vectorSize":2}},)"
                     R"({{"bufferView":2,"componentType":"uint16"}},)"
                     R"({{"bufferView":3,"componentType":"uint16"}}],"meshes":[{{"vertices":0,)"
                     R"("surfaces":[{{"edges":1,"geometry":[2,3]}}]}}]}})",
                     all.size(), dataUri(all), views);
}

TEST(G4mf, PolyhedraOfASurfaceWithoutSimplexesBecomeTetrahedra) {
  for (const fixtures::Polytope& polytope : fixtures::polytopes()) {
    LoadedMesh4d loaded = read4dBytes("polytope.g4tf", g4mfGeometry(polytope));
    ASSERT_EQ(loaded.bodies.size(), 1U);
    turnOutward(loaded.bodies[0]);
    EXPECT_NEAR(hypervolumeOf(loaded.bodies), polytope.hypervolume, 1e-12) << polytope.name;
  }
  std::string text = g4mfGeometry(fixtures::tesseract());
  const std::string exchanged = R"("geometry":[3,2])";
  text.replace(text.find(R"("geometry":[2,3])"), exchanged.size(), exchanged);
  EXPECT_EQ(error4dOf("a.g4tf", text),
            "a.g4tf: the geometry of mesh 0 has a number that is out of range");
}

TEST(G4mf, HiddenNodesAreNoted) {
  const std::string nodes = R"("nodes":[{"children":[1,2]},{"meshInstance":{"mesh":0}},)"
                            R"({"visible":false,"children":[3]},{"meshInstance":{"mesh":0}}])";
  std::string text = sixteenCell("");
  text.resize(text.find(R"("nodes")"));
  const LoadedMesh4d loaded = read4dBytes("a.g4tf", text + nodes + "}");
  EXPECT_EQ(loaded.bodies.size(), 1U);
  EXPECT_EQ(loaded.notices,
            std::vector<std::string>{"1 node that the file hides, and what is below, not read"});
}

TEST(G4mf, WhatIsNotReadIsListedAsLost) {
  const LoadedMesh4d skinned = read4dBytes("a.g4tf", sixteenCell(R"(,"skin":{"groups":2})"));
  EXPECT_EQ(skinned.losses,
            std::vector<std::string>{(temporaryPath("a.g4tf").string() + ": skins are not read")});
}

/// A binary file of these chunks: type, encoding, bytes.
std::string g4b(const std::vector<std::array<std::string, 3>>& chunks) {
  std::string file;
  for (const auto& [type, encoding, bytes] : chunks) {
    file.resize((file.size() + 15) / 16 * 16, '\0');
    file += type + (encoding.empty() ? std::string(4, '\0') : encoding) +
            bytesOf(std::uint64_t{bytes.size()}) + bytes;
  }
  return "G4MF" + std::string(4, '\0') + bytesOf(std::uint64_t{16 + file.size()}) + file;
}

TEST(G4mf, ChunksMayComeInAnyOrder) {
  const std::string other = "0123456789";
  const std::string blob = simplexData();
  const std::string older = g4mfText(R"({"byteLength":100})", kMeshes);
  const auto byNumber = [](int chunk) {
    return g4mfText(fmt::format(R"({{"byteLength":100,"chunk":{}}})", chunk), kMeshes);
  };
  for (const std::string& file :
       {g4b({{"JSON", "", older}, {"BLOB", "", blob}}),
        g4b({{"BLOB", "", blob}, {"JSON", "", older}}),
        g4b({{"BLOB", "", blob}, {"JSON", "", byNumber(0)}}),
        g4b({{"JSON", "", byNumber(2)}, {"BLOB", "", other}, {"BLOB", "", blob}}),
        g4b({{"NEWS", "", other}, {"BLOB", "", blob}, {"JSON", "", byNumber(1)}})}) {
    EXPECT_DOUBLE_EQ(hypervolumeOf(read4dBytes("a.g4b", file).bodies), kSimplexHypervolume);
  }
  EXPECT_EQ(error4dOf("a.g4b", g4b({{"JSON", "", byNumber(7)}, {"BLOB", "", blob}})),
            "a.g4b: the 'chunk' of buffer 0 is 7, but there are 2");
  EXPECT_EQ(error4dOf("a.g4b", g4b({{"BLOB", "", blob}})),
            "a.g4b: has no chunk of type JSON among its 1");
  EXPECT_EQ(error4dOf("a.g4b", g4b({{"JSON", "Zstd", other}})),
            "a.g4b: byte 20: the chunk 'JSON' is compressed as 'Zstd', expected plain JSON");
}

TEST(G4mf, RotorsTurnTheFirstAxisOfAPlaneTowardsTheSecond) {
  const std::string buffer = R"({"byteLength":100,"uri":)" + dataUri(simplexData()) + "}";
  const auto verticesOf = [&](const std::string& rotor) {
    const LoadedMesh4d loaded = read4dBytes(
        "a.g4tf", g4mfText(buffer, kMeshes,
                           R"(,"nodes":[{"mesh":0,"scale":[1,2,3,4],"rotor":)" + rotor + "}]"));
    EXPECT_EQ(loaded.bodies.size(), 1U);
    EXPECT_NEAR(hypervolumeOf(loaded.bodies), 24 * kSimplexHypervolume, 1e-12);
    return loaded.bodies.empty() ? std::vector<model::Point4>(5) : loaded.bodies[0].vertices;
  };
  constexpr std::array<std::array<int, 2>, 6> kPlanes = {
      {{0, 1}, {0, 2}, {1, 2}, {0, 3}, {1, 3}, {2, 3}}};
  for (std::size_t plane = 0; plane < 6; ++plane) {
    // A rotation with cosine 0.28 and sine 0.96.
    std::vector<double> rotor(7 + plane % 2);
    rotor[0] = 0.8;
    rotor[1 + plane] = 0.6;
    const auto vertices = verticesOf(fmt::format("[{}]", fmt::join(rotor, ",")));
    const auto [first, second] = kPlanes[plane];
    for (int axis = 0; axis < 4; ++axis) {
      model::Point4 expected = model::Point4::Unit(axis);
      if (axis == first) expected = 0.28 * expected + 0.96 * model::Point4::Unit(second);
      if (axis == second) expected = 0.28 * expected - 0.96 * model::Point4::Unit(first);
      expected *= axis + 1;  // the scale is along its own axes
      EXPECT_LE((vertices[static_cast<std::size_t>(axis) + 1] - expected).norm(), 1e-12)
          << plane << " " << axis;
    }
  }
  // A turn in xy and zw at once: the product of both rotors.
  const auto both = verticesOf("[0.64,0.48,0,0,0,0,0.48,0.36]");
  EXPECT_LE((both[1] - model::Point4(0.28, 0.96, 0, 0)).norm(), 1e-12);
  EXPECT_LE((both[3] - 3 * model::Point4(0, 0, 0.28, 0.96)).norm(), 1e-12);
}

TEST(G4mf, IsReadFromFilesBesideItAndFromZstd) {
  writeFile("data.bin", simplexData() + "more");
  EXPECT_DOUBLE_EQ(
      hypervolumeOf(
          read4dBytes("a.g4tf", g4mfText(R"({"byteLength":100,"uri":"data.bin"})", kMeshes))
              .bodies),
      kSimplexHypervolume);
  const std::string raw = simplexData();
  std::string packed(ZSTD_compressBound(raw.size()), '\0');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), raw.data(), raw.size(), 3));
  std::string json = g4mfText(R"({"byteLength":100,"compression":"Zstd"})", kMeshes);
  json.resize((json.size() + 15) / 16 * 16, ' ');
  const std::uint64_t size = 48 + json.size() + packed.size();
  const LoadedMesh4d loaded =
      read4dBytes("a.g4b", "G4MF" + std::string(4, '\0') + bytesOf(size) + "JSON" +
                               std::string(4, '\0') + bytesOf(std::uint64_t{json.size()}) + json +
                               "BLOBZstd" + bytesOf(std::uint64_t{packed.size()}) + packed);
  EXPECT_DOUBLE_EQ(hypervolumeOf(loaded.bodies), kSimplexHypervolume);
  EXPECT_EQ(loaded.dialect, "binary, draft");
}

/// A simplex whose vertices are numbers of this type, of so many bytes; the last vertex is (0, 0,
/// 0, `height`) instead of (0, 0, 0, 1).
std::string simplexOf(const std::string& type, const std::string& one, const std::string& height) {
  const std::size_t size = one.size();
  std::string data;
  for (int vertex = 0; vertex < 5; ++vertex) {
    for (int i = 0; i < 4; ++i) {
      data += vertex != i + 1 ? std::string(size, '\0') : i == 3 ? height : one;
    }
  }
  data += simplexData().substr(80);
  return fmt::format(
      R"({{"asset":{{"dimension":4}},"buffers":[{{"byteLength":{},"uri":{}}}],)"
      R"("bufferViews":[{{"byteLength":{}}},{{"byteLength":20,"byteOffset":{}}}],"accessors":[)"
      R"({{"bufferView":0,"componentType":"{}","vectorSize":4}},)"
      R"({{"bufferView":1,"componentType":"uint8","vectorSize":4}}],"meshes":{}}})",
      data.size(), dataUri(data), 20 * size, 20 * size, type, kMeshes);
}

TEST(G4mf, NumbersOfEveryTypeAreRead) {
  const auto heightOf = [](const std::string& type, const std::string& one,
                           const std::string& height) {
    return 24 * hypervolumeOf(read4dBytes("a.g4tf", simplexOf(type, one, height)).bodies);
  };
  // Floating-point numbers by their bits: 1, the least and the largest number, and another.
  const std::string one8 = "\x38";
  EXPECT_EQ(heightOf("float8", one8, std::string("\x01")), std::ldexp(1, -9));
  EXPECT_EQ(heightOf("float8", one8, "\x77"), 240);
  EXPECT_EQ(heightOf("float8", one8, "\x3D"), 1.625);
  const std::string one16 = bytesOf(std::uint16_t{0x3C00});
  EXPECT_EQ(heightOf("float16", one16, bytesOf(std::uint16_t{1})), std::ldexp(1, -24));
  EXPECT_EQ(heightOf("float16", one16, bytesOf(std::uint16_t{0x7BFF})), 65504);
  EXPECT_EQ(heightOf("float16", one16, bytesOf(std::uint16_t{0x3555})), 0.333251953125);
  const auto wide = [](std::uint64_t high, std::uint64_t low) {
    return bytesOf(low) + bytesOf(high);
  };
  const std::string one128 = wide(0x3FFF'0000'0000'0000, 0);
  EXPECT_DOUBLE_EQ(heightOf("float128", one128, wide(0x4000'921F'B544'42D1, 0x8469'898C'C517'01B8)),
                   std::numbers::pi);
  EXPECT_EQ(heightOf("float128", one128, wide(0x407F'0000'0000'0000, 0)), std::ldexp(1, 128));
  EXPECT_EQ(heightOf("uint128", wide(0, 1), wide(1, 0)), std::ldexp(1, 64));
  EXPECT_EQ(heightOf("int128", wide(0, 1), wide(~std::uint64_t{0}, 0)), -std::ldexp(1, 64));
  EXPECT_EQ(heightOf("uint16", bytesOf(std::uint16_t{1}), bytesOf(std::uint16_t{65535})), 65535);
  EXPECT_EQ(heightOf("int64", bytesOf(std::int64_t{1}), bytesOf(std::int64_t{-3})), -3);
  for (const char* infinite : {"\x78", "\x79"}) {  // infinity, and no number
    EXPECT_THAT(error4dOf("a.g4tf", simplexOf("float8", one8, infinite)),
                testing::HasSubstr("finite"));
  }
  EXPECT_THAT(error4dOf("a.g4tf", simplexOf("float4", one8, one8)),
              testing::HasSubstr("has numbers of type 'float4'; expected one of float64, float32"));
}

TEST(G4mf, NamesAreUniqueAndAsTheFormatAllowsThem) {
  std::vector<Mesh4d> bodies;
  for (const char* name : {"a", "a/b", "a_b", "", "t = 0.5", "\xC2\x85\xC3\xA9", "a_b 2"}) {
    bodies.push_back(smallBodies()[0]);
    bodies.back().name = name;
  }
  const auto path = written4d(*mesh4dFormat("g4tf"), bodies);
  std::vector<std::string> names;
  const auto document = nlohmann::json::parse(std::ifstream(path));
  for (const auto& node : document["nodes"]) {
    names.push_back(node.value("name", ""));
  }
  EXPECT_THAT(names,
              testing::ElementsAre("", "a", "a_b", "a_b 2", "", "t = 0_5", "_\xC3\xA9", "a_b 2 2"));
  const auto loaded = read4d(path);
  ASSERT_TRUE(loaded);
  ASSERT_EQ(loaded->bodies.size(), bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    EXPECT_EQ(loaded->bodies[i].name, bodies[i].name);
  }
}

TEST(G4mf, SaysWhatIsWrong) {
  const std::string buffer = R"({"byteLength":100,"uri":)" + dataUri(simplexData()) + "}";
  EXPECT_EQ(error4dOf("a.g4tf", R"({"asset":{"dimension":3}})"),
            "a.g4tf: is a model of dimension 3, expected 4");
  EXPECT_EQ(error4dOf("a.g4tf", R"({"asset":{"dimension":4}})"), "a.g4tf: holds no tetrahedra");
  for (const std::string outside : {"../data.bin", "/etc/passwd", "https://example.com/data.bin"}) {
    EXPECT_EQ(
        error4dOf("a.g4tf", g4mfText(R"({"byteLength":100,"uri":")" + outside + "\"}", kMeshes)),
        "a.g4tf: a buffer is in '" + outside + "', which is not a file in this folder");
  }
  EXPECT_EQ(
      error4dOf("a.g4tf",
                g4mfText(R"({"byteLength":101,"uri":)" + dataUri(simplexData()) + "}", kMeshes)),
      "a.g4tf: buffer 0 has 100 bytes of 101");
  EXPECT_EQ(
      error4dOf("a.g4tf", g4mfText(buffer, R"([{"vertices":0,"surfaces":[{"simplexes":7}]}])")),
      "a.g4tf: 'simplexes' is '7', which is not an index into the 2 accessors");
  EXPECT_EQ(error4dOf("a.g4tf",
                      g4mfText(buffer, kMeshes, R"(,"nodes":[{"children":[1]},{"children":[1]}])")),
            "a.g4tf: node 1 is below itself, has two parents or is too deep");
  EXPECT_EQ(error4dOf("a.g4tf",
                      g4mfText(buffer, kMeshes, R"(,"nodes":[{"mesh":0,"rotor":[1,0,0,0,0,0]}])")),
            "a.g4tf: the 'rotor' of a node is not 7 or 8 numbers");
  // Turns in two planes at once need the last number.
  for (const char* rotor : {"[2,0,0,0,0,0,0]", "[0.6,0.64,0,0,0,0,0.48]"}) {
    EXPECT_NE(
        error4dOf("a.g4tf", g4mfText(buffer, kMeshes,
                                     R"(,"nodes":[{"mesh":0,"rotor":)" + std::string(rotor) + "}]"))
            .find("of a node is not a rotation"),
        std::string::npos);
  }
  EXPECT_EQ(error4dOf("a.g4b", "G4MF" + bytesOf(std::uint32_t{1}) + std::string(40, '\0')),
            "a.g4b: byte 4: is version 1 of binary G4MF, expected 0, the draft");
  // A mesh of 10,000 vertices that a thousand nodes place.
  const std::string many(160000, '\0');
  std::string nodes = R"(,"nodes":[{"children":[1)";
  for (int i = 2; i <= 1000; ++i) nodes += fmt::format(",{}", i);
  nodes += "]}";
  for (int i = 1; i <= 1000; ++i) nodes += R"(,{"mesh":0})";
  std::string document =
      g4mfText(R"({"byteLength":160000,"uri":)" + dataUri(many) + "}", kMeshes, nodes + "]");
  document.replace(document.find(R"("byteLength":80})"), 16, R"("byteLength":160000})");
  EXPECT_EQ(error4dOf("bomb.g4tf", document), "bomb.g4tf: mesh 0: holds no tetrahedra");
}

}  // namespace
}  // namespace t4d::formats
