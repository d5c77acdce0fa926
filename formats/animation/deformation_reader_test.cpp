#include "formats/animation/deformation_reader.h"

#include <bit>
#include <random>

#include <fmt/format.h>

#include "formats/numbered_files.h"
#include "formats/test_files.h"

namespace t4d::formats {
namespace {

using model::Point3;

/// A cube of squares, scaled and moved, with a point that no face uses after the first corner.
std::string cubeObj(double size, double shift) {
  std::string text;
  for (int i = 0; i < 8; ++i) {
    const Point3 p = size * cubeCorner(i) + Point3(shift, 0, 0);
    text += fmt::format("v {} {} {}\n", p.x(), p.y(), p.z());
    if (i == 0) text += "v 9 9 9\n";
  }
  for (const auto& square : kCubeSquares) {
    text += "f";
    for (const int corner : square) text += fmt::format(" {}", corner == 0 ? 1 : corner + 2);
    text += "\n";
  }
  return text;
}

/// The nine points of cubeObj.
std::vector<Point3> cubePoints(double size, double shift) {
  std::vector<Point3> points;
  for (int i = 0; i < 8; ++i) {
    points.emplace_back(size * cubeCorner(i) + Point3(shift, 0, 0));
    if (i == 0) points.emplace_back(9, 9, 9);
  }
  return points;
}

std::string reversed(std::string bytes) { return {bytes.rbegin(), bytes.rend()}; }

template <class T>
std::string number(T value, std::endian order) {
  return order == std::endian::little ? bytesOf(value) : reversed(bytesOf(value));
}

std::string samplesOf(const std::vector<std::vector<Point3>>& samples, std::endian order) {
  std::string bytes;
  for (const auto& points : samples) {
    for (const Point3& point : points) {
      for (const double x : point) bytes += number(static_cast<float>(x), order);
    }
  }
  return bytes;
}

std::string pc2(const std::vector<std::vector<Point3>>& samples, float first = 0, float rate = 1) {
  return std::string("POINTCACHE2\0", 12) + bytesOf(std::int32_t{1}) +
         bytesOf(static_cast<std::int32_t>(samples[0].size())) + bytesOf(first) + bytesOf(rate) +
         bytesOf(static_cast<std::int32_t>(samples.size())) +
         samplesOf(samples, std::endian::little);
}

std::string mdd(const std::vector<std::vector<Point3>>& samples, const std::vector<float>& times) {
  constexpr auto kBig = std::endian::big;
  std::string bytes = number(static_cast<std::int32_t>(samples.size()), kBig) +
                      number(static_cast<std::int32_t>(samples[0].size()), kBig);
  for (const float time : times) bytes += number(time, kBig);
  return bytes + samplesOf(samples, kBig);
}

std::vector<std::vector<Point3>> threeCubes() {
  return {cubePoints(1, 0), cubePoints(2, 0.5), cubePoints(1.5, 1)};
}

std::string withoutFolder(std::string text) {
  const std::string folder = temporaryPath("").string();
  for (auto at = text.find(folder); at != text.npos; at = text.find(folder)) {
    text.erase(at, folder.size());
  }
  return text;
}

/// The error of opening a deformation, or of the first key that cannot be read.
std::string problemOf(const Result<LoadedDeformation>& loaded) {
  if (!loaded) return withoutFolder(loaded.error().text());
  std::vector<Point3> positions(loaded->solid.mesh.vertices.size());
  for (std::uint64_t key = 0; key < loaded->keys->count(); ++key) {
    const auto read = loaded->keys->positions(key, positions);
    if (!read) return withoutFolder(read.error().text());
    for (const Point3& position : positions) EXPECT_TRUE(position.allFinite());
    EXPECT_TRUE(key == 0 || loaded->keys->time(key) > loaded->keys->time(key - 1));
  }
  return "(was accepted)";
}

Result<LoadedDeformation> cached(const std::string& name, const std::string& bytes,
                                 const KeyTimes& times = {}) {
  return readCachedMesh(writeFile("solid.obj", cubeObj(1, 0)), writeFile(name, bytes), times);
}

Result<LoadedDeformation> series(const std::vector<std::pair<std::string, std::string>>& files,
                                 const KeyTimes& times = {{}, 0.5}) {
  std::vector<std::filesystem::path> paths;
  for (const auto& [name, bytes] : files) paths.push_back(writeFile(name, bytes));
  return readMeshSeries(paths, times);
}

/// Checks that the keys are those of threeCubes.
void expectThreeCubes(const Result<LoadedDeformation>& loaded) {
  ASSERT_TRUE(loaded) << loaded.error().text();
  ASSERT_EQ(loaded->keys->count(), 3U);
  ASSERT_EQ(loaded->solid.mesh.vertices.size(), 8U);
  std::vector<Point3> positions(8);
  for (std::uint64_t key = 0; key < 3; ++key) {
    ASSERT_TRUE(loaded->keys->positions(key, positions));
    auto expected = threeCubes()[key];
    expected.erase(expected.begin() + 1);
    EXPECT_EQ(positions, expected);
    EXPECT_FALSE(loaded->keys->pose(key));
  }
}

TEST(DeformationReader, ReadsPc2) {
  const auto loaded = cached("a.pc2", pc2(threeCubes(), 10, 0.5F));
  expectThreeCubes(loaded);
  EXPECT_EQ(loaded->keys->time(0), 10);
  EXPECT_EQ(loaded->keys->time(2), 11);
}

TEST(DeformationReader, ReadsMdd) {
  const auto loaded = cached("a.mdd", mdd(threeCubes(), {0, 0.25F, 1}));
  expectThreeCubes(loaded);
  EXPECT_EQ(loaded->keys->time(1), 0.25);
  EXPECT_EQ(loaded->keys->time(2), 1);
}

TEST(DeformationReader, MeshesStayInTheOrderGiven) {
  const auto loaded = series({{"cube_9.obj", cubeObj(1, 0)},
                              {"cube_11.obj", cubeObj(2, 0.5)},
                              {"cube_10.obj", cubeObj(1.5, 1)}});
  expectThreeCubes(loaded);
  EXPECT_EQ(loaded->keys->time(2), 1);
}

TEST(DeformationReader, TimesCanBeGiven) {
  const auto between = cached("a.pc2", pc2(threeCubes()), {model::TimeSpan{2, 3}, {}});
  EXPECT_EQ(between->keys->time(0), 2);
  EXPECT_EQ(between->keys->time(1), 2.5);
  EXPECT_EQ(between->keys->time(2), 3);
  EXPECT_EQ(cached("a.pc2", pc2(threeCubes()), {{}, 0.7})->keys->time(2), 1.4);
  const auto none = series({{"a1.obj", cubeObj(1, 0)}, {"a2.obj", cubeObj(1, 1)}}, {});
  ASSERT_TRUE(none);
  EXPECT_EQ(none->keys->time(1), 1);
}

TEST(DeformationReader, SeriesThatDoNotMatchAreRefused) {
  const std::string cube = cubeObj(1, 0);
  const std::string moved = cubeObj(1, 1);
  EXPECT_EQ(problemOf(series({{"a1.obj", cube}, {"a2.obj", moved}, {"a4.obj", moved}})),
            "a4.obj: follows a2.obj: number 3 is missing; name all files of the series, or give "
            "them numbers without gaps");
  EXPECT_EQ(problemOf(series({{"a1.obj", cube}, {"a01.obj", moved}})),
            "a01.obj: has the same number as a1.obj");
  EXPECT_EQ(problemOf(series({{"a1.obj", cube}, {"a2.obj", "v 0 0 0\n" + moved}})),
            "a2.obj: has 10 points and 6 faces, a1.obj has 9 and 6; every mesh of a series must "
            "have the same points and faces in the same order");
  std::string other = moved;
  other.replace(other.find("f 1 "), 4, "f 9 ");
  EXPECT_EQ(problemOf(series({{"a1.obj", cube}, {"a2.obj", other}})),
            "a2.obj: its faces join other points than those of a1.obj; every mesh of a series must "
            "have the same points and faces in the same order");
  EXPECT_EQ(problemOf(series({{"a1.obj", cube}, {"a2.obj", "v 0 0\n"}})),
            "a2.obj:1: the line ends, expected a coordinate");
}

TEST(DeformationReader, PointsOfOneVertexStayTogether) {
  // Triangles that share no points in the file, as in .stl.
  const auto tetrahedron = [](double apart) {
    const Point3 corners[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const int triangles[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    std::string text;
    int point = 0;
    for (const auto& triangle : triangles) {
      for (const int corner : triangle) {
        const double shift = point++ == 11 ? apart : 0;
        text += fmt::format("v {} {} {}\n", corners[corner].x(), corners[corner].y(),
                            corners[corner].z() + shift);
      }
    }
    return text + "f 1 2 3\nf 4 5 6\nf 7 8 9\nf 10 11 12\n";
  };
  EXPECT_EQ(problemOf(series({{"t1.obj", tetrahedron(0)}, {"t2.obj", tetrahedron(1e-7)}})),
            "(was accepted)");
  EXPECT_EQ(problemOf(series({{"t1.obj", tetrahedron(0)}, {"t2.obj", tetrahedron(0.25)}})),
            "t2.obj: points 5 and 11 (counted from 0) are one vertex of the mesh, but 0.25 apart "
            "here: the surface would tear");
}

TEST(DeformationReader, CachesThatDoNotMatchAreRefused) {
  const auto good = threeCubes();
  auto fewer = good;
  for (auto& points : fewer) points.pop_back();
  EXPECT_EQ(problemOf(cached("a.pc2", pc2(fewer))),
            "a.pc2: has 8 points, solid.obj has 9; a cache belongs to the mesh file that it was "
            "made with");
  auto broken = good;
  broken[1][3].y() = std::nan("");
  EXPECT_TRUE(problemOf(cached("a.pc2", pc2(broken))).starts_with("a.pc2: byte 176: sample 1, "));
  EXPECT_EQ(problemOf(cached("a.pc2", pc2({good[0]}))),
            "a.pc2: byte 16: 1 sample, expected at least 2");
  EXPECT_TRUE(problemOf(cached("a.pc2", pc2(good, 0, 0))).starts_with("a.pc2: byte 20: "));
  std::string huge = pc2(good);
  huge.replace(28, 4, "\xff\xff\xff\x7f");
  EXPECT_EQ(problemOf(cached("a.pc2", huge)),
            "a.pc2: byte 16: declares 2147483647 samples of 9 points, 12 bytes each; 324 bytes "
            "follow");
  for (const auto& [byte, counts] :
       {std::pair{16, "-1 points and 3 samples"}, std::pair{28, "9 points and -1 samples"}}) {
    std::string fewerThanNone = pc2(good);
    fewerThanNone.replace(static_cast<std::size_t>(byte), 4, "\xff\xff\xff\xff");
    EXPECT_EQ(problemOf(cached("a.pc2", fewerThanNone)),
              fmt::format("a.pc2: byte 16: declares {}", counts));
  }
  std::string other = pc2(good);
  other[12] = 2;
  EXPECT_EQ(problemOf(cached("a.pc2", other)), "a.pc2: byte 12: is version 2, expected 1");
  EXPECT_EQ(problemOf(cached("a.pc2", "hello")),
            "a.pc2: byte 5: the file ends in the header of 32 bytes");
  EXPECT_EQ(problemOf(cached("a.mdd", mdd(good, {0, 1, 1}))),
            "a.mdd: key 2 (counted from 0) is at time 1, not after the key before it, at 1: a 4D "
            "mesh cannot go backward through time");
  huge = mdd(good, {0, 1, 2});
  huge[0] = '\x7f';
  EXPECT_EQ(problemOf(cached("a.mdd", huge)),
            "a.mdd: byte 0: declares 2130706435 samples, whose times the 336 bytes that follow "
            "cannot hold");
}

TEST(DeformationReader, DamagedCachesAreReadOrRefused) {
  std::mt19937 random(3);
  for (const auto& [name, bytes] :
       {std::pair{"d.pc2", pc2(threeCubes())}, std::pair{"d.mdd", mdd(threeCubes(), {0, 1, 2})}}) {
    for (std::size_t size = 1; size < bytes.size(); ++size) {
      EXPECT_NE(problemOf(cached(name, bytes.substr(0, size))), "(was accepted)") << size;
    }
    EXPECT_NE(problemOf(cached(name, bytes + "x")), "(was accepted)");
    for (std::size_t at = 0; at < bytes.size(); ++at) {
      std::string damaged = bytes;
      damaged[at] = static_cast<char>(damaged[at] + 1 + static_cast<char>(random() % 255));
      EXPECT_FALSE(problemOf(cached(name, damaged)).empty());
    }
  }
}

TEST(NumberedFiles, OnlyThoseThatCountUpAreASeries) {
  using Files = std::vector<std::filesystem::path>;
  for (const Files& files : {Files{"rest.obj", "bent.obj", "a7.obj"}, Files{"a/1.obj", "b/3.obj"},
                             Files{"a3.obj", "a1.obj"}, Files{"a9.obj", "a10.obj"}}) {
    EXPECT_TRUE(checkNumbers(files)) << files.front();
  }
  EXPECT_FALSE(checkNumbers(Files{"a8.obj", "a10.obj"}));
}

}  // namespace
}  // namespace t4d::formats
