#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "measure/overlap_depth.h"
#include "t4d/check.h"

namespace t4d::measure {
namespace {

using model::Point3;
using model::TriangleMesh;

TriangleMesh together(TriangleMesh one, const TriangleMesh& other) {
  const auto first = static_cast<std::uint32_t>(one.vertices.size());
  one.vertices.insert(one.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const auto& [a, b, c] : other.triangles) {
    one.triangles.push_back({first + a, first + b, first + c});
  }
  return one;
}

/// The difference of a cube of side 2 and the same cube moved.
double movedCubeDifference(const Eigen::Vector3d& by) {
  const Eigen::Vector3d common = (2 - by.array().abs()).max(0);
  return 2 * (8 - common.prod());
}

TEST(SolidDifference, OfMovedCubesIsTheClosedForm) {
  const TriangleMesh cube = fixtures::cube(2);
  for (const Eigen::Vector3d& by : {Eigen::Vector3d(0.25, 0, 0), Eigen::Vector3d(0.1, -0.2, 0.3),
                                    Eigen::Vector3d(1e-3, 0, 0), Eigen::Vector3d(0, 5, -7)}) {
    const auto difference = solidDifference(cube, fixtures::translated(cube, by));
    ASSERT_TRUE(difference);
    const double expected = movedCubeDifference(by);
    EXPECT_NEAR(difference->volume, expected, difference->error);
    EXPECT_NEAR(difference->volume, expected, 2e-3 * expected);
  }
}

TEST(SolidDifference, OfMovedSpheresIsTwiceWhatTheLensLeaves) {
  constexpr double kPi = std::numbers::pi;
  const TriangleMesh sphere = fixtures::icosphere(1, 5);
  const double d = 0.5;
  const double lens = kPi * (4 + d) * (2 - d) * (2 - d) / 12;
  const auto difference = solidDifference(sphere, fixtures::translated(sphere, {0, 0, d}));
  ASSERT_TRUE(difference);
  const double faceting = 4 * kPi / 3 - signedVolume(sphere);
  EXPECT_NEAR(difference->volume, 2 * (4 * kPi / 3 - lens), 2 * faceting + difference->error);
}

TEST(SolidDifference, OfNestedSolidsIsTheDifferenceOfVolumes) {
  const TriangleMesh inner = fixtures::icosphere(1, 3);
  const TriangleMesh outer = fixtures::icosphere(1.05, 3);
  const double expected = signedVolume(outer) - signedVolume(inner);
  const auto difference = solidDifference(inner, outer);
  EXPECT_NEAR(difference->volume, expected, difference->error);
  EXPECT_NEAR(difference->volume, expected, 1e-3 * expected);

  const auto cavity = solidDifference(fixtures::hollowCube(4, 2), fixtures::cube(4));
  EXPECT_NEAR(cavity->volume, 8, cavity->error + 1e-12);
}

TEST(SolidDifference, FromNothingIsTheVolume) {
  for (const fixtures::NamedSolid& solid : fixtures::allSolids()) {
    const double volume = signedVolume(solid.mesh);
    const auto difference = solidDifference(solid.mesh, {});
    ASSERT_TRUE(difference) << solid.name;
    EXPECT_NEAR(difference->volume, volume, difference->error) << solid.name;
    EXPECT_NEAR(difference->volume, volume, 1e-3 * volume) << solid.name;
  }
  EXPECT_EQ(solidDifference({}, {})->volume, 0);
}

TEST(SolidDifference, OfEqualSolidsIsExactlyZero) {
  std::mt19937 random(4);
  for (const fixtures::NamedSolid& solid : fixtures::allSolids()) {
    TriangleMesh shuffled = solid.mesh;
    std::shuffle(shuffled.triangles.begin(), shuffled.triangles.end(), random);
    for (model::Triangle& triangle : shuffled.triangles) {
      std::rotate(triangle.begin(), triangle.begin() + random() % 3, triangle.end());
    }
    const auto difference = solidDifference(solid.mesh, shuffled);
    ASSERT_TRUE(difference) << solid.name;
    EXPECT_EQ(difference->volume, 0) << solid.name;
    EXPECT_EQ(difference->error, 0) << solid.name;
  }
}

TEST(SolidDifference, IsSymmetric) {
  const TriangleMesh torus = fixtures::torus(3, 1, 24, 12);
  const TriangleMesh cube = fixtures::cube(4);
  EXPECT_DOUBLE_EQ(solidDifference(torus, cube)->volume, solidDifference(cube, torus)->volume);
}

TEST(SolidDifference, CountsOverlapsAsVolumesDo) {
  // Two cubes that overlap, as one self-intersecting surface, against nothing and against itself.
  const TriangleMesh both =
      together(fixtures::cube(2), fixtures::translated(fixtures::cube(2), {0.5, 0.25, 0.125}));
  const auto difference = solidDifference(both, {});
  EXPECT_NEAR(difference->volume, 16, difference->error);
  EXPECT_NEAR(difference->volume, signedVolume(both), 1e-3 * 16);
  EXPECT_EQ(solidDifference(both, both)->volume, 0);
}

TEST(SolidDifference, CoarseLatticesDoNotLeak) {
  // A line that left a solid without having entered it would count with its whole length.
  for (int i = 0; i < 200; ++i) {
    const TriangleMesh torus = fixtures::torus(3, 1, 3 + i % 20, 3 + i / 20);
    const auto difference =
        solidDifference(torus, {}, {.resolution = static_cast<std::uint32_t>(4 + i % 13)});
    ASSERT_TRUE(difference);
    EXPECT_NEAR(difference->volume, signedVolume(torus), difference->error + 1);
  }
}

TEST(SolidDifference, ErrorFallsWithTheSquareOfTheSpacing) {
  const TriangleMesh cube = fixtures::cube(2);
  std::mt19937 random(6);
  std::uniform_real_distribution<double> number(-0.4, 0.4);
  constexpr int kPairs = 30;
  double coarse = 0;
  double fine = 0;
  int tooSmall = 0;  // estimates of the error
  for (int i = 0; i < kPairs; ++i) {
    const Eigen::Vector3d by(number(random), number(random), number(random));
    const TriangleMesh other = fixtures::translated(cube, by);
    const double expected = movedCubeDifference(by);
    const auto with32 = solidDifference(cube, other, {.resolution = 32});
    const auto with256 = solidDifference(cube, other, {.resolution = 256});
    coarse += std::abs(with32->volume - expected);
    fine += std::abs(with256->volume - expected);
    tooSmall += std::abs(with32->volume - expected) > with32->error ? 1 : 0;
    tooSmall += std::abs(with256->volume - expected) > with256->error ? 1 : 0;
  }
  EXPECT_LE(tooSmall, 2 * kPairs / 20);
  const double order = std::log2(coarse / fine) / 3;
  std::cout << "observed order " << order << "\n";
  EXPECT_GT(order, 1.7);
}

TEST(SolidDifference, IsTheSameFarAway) {
  const Eigen::Vector3d far(1e6, -2e6, 3e6);
  const TriangleMesh cube = fixtures::translated(fixtures::cube(2), far);
  const Eigen::Vector3d by(0.25, 0.125, 0);
  EXPECT_NEAR(solidDifference(cube, fixtures::translated(cube, by))->volume,
              movedCubeDifference(by), 1e-3);
}

TEST(SolidDifference, PartsFarApartAreNotMissed) {
  const auto boxAt = [](double x, double height) {
    model::TriangleMesh mesh = fixtures::cube(2);
    for (model::Point3& vertex : mesh.vertices) {
      vertex.x() += x;
      vertex.z() *= height / 2;
    }
    return mesh;
  };
  const auto both = [](model::TriangleMesh mesh, const model::TriangleMesh& other) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
    for (const auto& [a, b, c] : other.triangles) {
      mesh.triangles.push_back({a + first, b + first, c + first});
    }
    return mesh;
  };
  for (const double distance : {10.0, 1e3, 1e6, 1e9}) {
    EXPECT_NEAR(solidDifference(boxAt(0, 2), boxAt(distance, 2))->volume, 16, 0.01);
    const auto taller = solidDifference(both(boxAt(0, 2), boxAt(distance, 2)),
                                        both(boxAt(0, 2), boxAt(distance, 2.5)));
    EXPECT_NEAR(taller->volume, 2, 0.005);
  }
}

TEST(SolidDifference, OpenSurfacesAreRefused) {
  TriangleMesh open = fixtures::cube(2);
  open.triangles.pop_back();
  EXPECT_NE(solidDifference(open, {}).error().message.find("first surface"), std::string::npos);
  EXPECT_NE(solidDifference({}, open).error().message.find("second surface"), std::string::npos);
}

TriangleMesh turnedAtRandom(TriangleMesh mesh, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-1, 1);
  const Eigen::Quaterniond turn =
      Eigen::Quaterniond(number(random), number(random), number(random), number(random))
          .normalized();
  const Point3 to(10 * number(random), 10 * number(random), 10 * number(random));
  for (Point3& vertex : mesh.vertices) vertex = turn * vertex + to;
  return mesh;
}

double overlapOf(const TriangleMesh& a, const TriangleMesh& b) {
  const auto overlap = solidOverlap(a, b);
  EXPECT_TRUE(overlap) << overlap.error().text();
  return overlap ? overlap->volume : 0;
}

TEST(SolidOverlap, OfCornersIsTheirCubeHoweverSmall) {
  const TriangleMesh cube = fixtures::cube(2);
  for (std::uint32_t k = 1; k <= 9; ++k) {
    const double side = 3 * std::pow(10, -double(k));
    const TriangleMesh other = fixtures::translated(cube, Point3::Constant(2 - side));
    const double volume = side * side * side;
    // The tolerance allows for the rounding of coordinates.
    const double rounding = 1e-14 / side;
    EXPECT_NEAR(overlapOf(cube, other), volume, (0.005 + rounding) * volume) << side;
    EXPECT_NEAR(overlapOf(turnedAtRandom(cube, k), turnedAtRandom(other, k)), volume,
                (0.005 + 10 * rounding) * volume)
        << side;
  }
}

TEST(SolidOverlap, OfSpheresIsTheirLensHoweverThin) {
  // Two regular bodies of many faces, which meet face to face: the lens is two pyramids' tips.
  const TriangleMesh sphere = fixtures::icosphere(1, 4);
  for (const double thickness : {0.3, 0.1, 0.03}) {
    const double lens = std::numbers::pi * thickness * thickness * (6 - thickness) / 12;
    const TriangleMesh other = fixtures::translated(sphere, {0, 0, 2 - thickness});
    EXPECT_NEAR(overlapOf(sphere, other), lens, 0.1 * lens) << thickness;
  }
}

/// Octahedra whose tips are `depth` below the plane z = 0, at these places.
TriangleMesh tipsBelow(double depth, const std::vector<Point3>& places) {
  TriangleMesh all;
  for (const Point3& place : places) {
    all = together(all,
                   fixtures::translated(fixtures::bipyramid(4), place + Point3(0, 0, 1 - depth)));
  }
  return all;
}

TriangleMesh tableBelow(double side) {
  TriangleMesh table = fixtures::cube(side);
  for (Point3& vertex : table.vertices) vertex.z() = vertex.z() < 0 ? -1 : 0;
  return table;
}

TEST(SolidOverlap, OfTipsFarApartIsTheSumOfAllHoweverSmall) {
  const TriangleMesh table = tableBelow(100);
  const std::vector<Point3> places = {
      {0, 0, 0}, {30, 0.5, 0}, {-20, 31, 0}, {-45, -40, 0}, {44, -13, 0}};
  for (const double depth : {0.1, 1e-3, 1e-5}) {
    const double volume = 5 * 2 * depth * depth * depth / 3;
    EXPECT_NEAR(overlapOf(table, tipsBelow(depth, places)), volume, 0.02 * volume) << depth;
  }
}

TEST(SolidOverlap, OfATipWithinAFaceThatTouchesIsThatOfTheTip) {
  // A box stands on the table; the tip comes out of it below.
  TriangleMesh box = fixtures::cube(4);
  for (Point3& vertex : box.vertices) vertex.z() += 2;
  for (const double depth : {0.1, 1e-3, 1e-5}) {
    const double volume = 2 * depth * depth * depth / 3;
    const TriangleMesh standing = together(box, tipsBelow(depth, {{0.7, -0.4, 0}}));
    EXPECT_NEAR(overlapOf(tableBelow(20), standing), volume, 0.01 * volume) << depth;
    EXPECT_NEAR(overlapOf(standing, tableBelow(20)), volume, 0.01 * volume) << depth;
  }
  EXPECT_EQ(overlapOf(tableBelow(20), box), 0);
}

// Slices have such triangles next to a layer.
TriangleMesh withSlivers(TriangleMesh mesh) {
  const std::vector<model::Triangle> triangles = std::exchange(mesh.triangles, {});
  for (const auto& [a, b, c] : triangles) {
    const auto between = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.emplace_back(0.7 * mesh.vertices[a] + 0.3 * mesh.vertices[b]);
    mesh.triangles.insert(mesh.triangles.end(),
                          {{a, b, between}, {a, between, c}, {between, b, c}});
  }
  return mesh;
}

TEST(OverlapDepth, OfCubesWithCommonFacesIsRightAlsoWithSlivers) {
  TriangleMesh low = withSlivers(fixtures::cube(1));
  TriangleMesh high = low;
  for (Point3& vertex : high.vertices) vertex.y() += 0.99;
  EXPECT_NEAR(OverlapDepth(low, high).greatest(), 0.005, 0.0001);
}

TEST(SolidOverlap, OfSolidsWithCommonFacesIsTheSmallerOne) {
  const TriangleMesh cube = fixtures::cube(2);
  EXPECT_NEAR(overlapOf(cube, cube), 8, 0.05);
  // The cube is in a corner of the other; then both are the same cube of other triangles.
  const TriangleMesh large = fixtures::translated(fixtures::cube(4), {1, 1, 1});
  EXPECT_NEAR(overlapOf(cube, large), 8, 0.05);
  EXPECT_NEAR(overlapOf(large, fixtures::paperCube(2)), 8, 0.05);
  EXPECT_NEAR(overlapOf(cube, fixtures::paperCube(2)), 8, 0.05);
  // The cube is inside, without a common point of the surfaces, and in a cavity.
  EXPECT_NEAR(overlapOf(fixtures::cube(1e-4), cube), 1e-12, 1e-14);
  EXPECT_EQ(overlapOf(fixtures::cube(1), fixtures::hollowCube(4, 2)), 0);
}

}  // namespace
}  // namespace t4d::measure
