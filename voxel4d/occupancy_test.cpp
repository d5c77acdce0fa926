#include "voxel4d/occupancy.h"

#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "model/parallel.h"
#include "t4d/motion.h"

namespace t4d::voxel4d {
namespace {

using model::Point3;
using model::TriangleMesh;

std::uint64_t countOf(const Frame& frame) {
  std::uint64_t count = 512 * frame.tiles.size();
  for (const Block& block : frame.blocks) {
    for (const std::uint64_t word : block.inside) count += std::popcount(word);
  }
  return count;
}

TriangleMesh posed(TriangleMesh mesh, const model::Pose& pose) {
  for (Point3& vertex : mesh.vertices) vertex = pose(vertex);
  return mesh;
}

model::Pose turned(double degrees, const Eigen::Vector3d& axis, const Point3& shift) {
  return {Eigen::AngleAxisd(degrees * std::numbers::pi / 180, axis.normalized()).toRotationMatrix(),
          shift};
}

std::uint64_t countInside(const TriangleMesh& mesh, const Lattice& lattice = {}) {
  const auto frame = occupancy(mesh, lattice, 0);
  EXPECT_TRUE(frame) << frame.error().text();
  return frame ? countOf(*frame) : 0;
}

std::string refusal(const TriangleMesh& mesh, const Lattice& lattice = {}) {
  const auto frame = occupancy(mesh, lattice, 0);
  return frame ? "(was accepted)" : frame.error().text();
}

bool isInside(const Frame& frame, int x, int y, int z) {
  return (insideOf(frame, {x >> 3, y >> 3, z >> 3})[x & 7] >> (8 * (y & 7) + (z & 7)) & 1U) != 0;
}

TEST(Occupancy, PointsOnTheSurfaceAreOutside) {
  // All six faces, twelve edges and eight corners of the paper's cube lie on lattice points.
  for (const int side : {2, 4, 20, 40}) {
    const std::uint64_t points = side - 1;
    EXPECT_EQ(countInside(fixtures::paperCube(side)), points * points * points);
    EXPECT_EQ(countInside(fixtures::cube(side)), points * points * points);
  }
  const auto shifted = posed(fixtures::paperCube(20), {Eigen::Matrix3d::Identity(), {0, 3, -1000}});
  EXPECT_EQ(countInside(shifted), 6859U);
}

TEST(Occupancy, SurfaceMovedByARoundingIsStillTheSurface) {
  for (const double part : {-1e-14, 1e-14}) {
    EXPECT_EQ(countInside(fixtures::paperCube(20 * (1 + part))), 6859U);
  }
  // Rotated there in three steps, so that its corners have rounding errors.
  auto cube = fixtures::paperCube(20);
  for (int i = 0; i < 3; ++i) cube = posed(cube, turned(30, {0, 1, 0}, {0, 0, 0}));
  EXPECT_EQ(countInside(cube), 6859U);
  cube = posed(cube, turned(120, {1, 1, 1}, {7, -20, 3}));
  EXPECT_EQ(countInside(cube), 6859U);
}

TEST(Occupancy, IsThePointsOfTheClosedFormInGeneralPosition) {
  const auto pose = turned(37, {1, -2, 3}, {0.31, -4.7, 11.13});
  const auto frame = occupancy(posed(fixtures::paperCube(20), pose), {}, 0);
  ASSERT_TRUE(frame);
  std::uint64_t expected = 0;
  for (int x = -20; x <= 20; ++x) {
    for (int y = -25; y <= 15; ++y) {
      for (int z = -9; z <= 31; ++z) {
        const Point3 p = pose.rotation.transpose() * (Point3(x, y, z) - pose.translation);
        const bool inside = p.cwiseAbs().maxCoeff() < 10;
        expected += inside ? 1 : 0;
        ASSERT_EQ(isInside(*frame, x, y, z), inside) << x << " " << y << " " << z;
      }
    }
  }
  EXPECT_EQ(countOf(*frame), expected);
}

TEST(Occupancy, CountsApproachTheVolume) {
  for (const auto& solid : fixtures::allSolids()) {
    const double volume = signedVolume(solid.mesh);
    const double area = surfaceArea(solid.mesh);
    const double h = 0.25;
    const auto pose = turned(20, {3, 2, 1}, {0.1, 0.02, 0.003});
    const double counted =
        static_cast<double>(countInside(posed(solid.mesh, pose), {h, Point3(0.7, -0.3, 0.2)}));
    EXPECT_NEAR(counted * h * h * h, volume, 0.1 * area * h) << solid.name;
  }
}

TEST(Occupancy, CavitiesAreOutside) {
  EXPECT_EQ(countInside(fixtures::hollowCube(20, 10)), 6859U - 11U * 11U * 11U);
}

TEST(Occupancy, OverlapsCountOnceAndOrientationDoesNotMatter) {
  TriangleMesh two = fixtures::cube(20);
  const TriangleMesh other = posed(fixtures::cube(20), {Eigen::Matrix3d::Identity(), {10, 0, 0}});
  for (const auto& [a, b, c] : other.triangles) two.triangles.push_back({8 + a, 8 + b, 8 + c});
  two.vertices.insert(two.vertices.end(), other.vertices.begin(), other.vertices.end());
  // Faces within the union bound nothing.
  EXPECT_EQ(countInside(two), 29U * 19U * 19U);
  TriangleMesh turnedInsideOut = fixtures::paperCube(20);
  for (auto& triangle : turnedInsideOut.triangles) std::swap(triangle[0], triangle[1]);
  EXPECT_EQ(countInside(turnedInsideOut), 6859U);
}

TEST(Occupancy, ColumnsThroughEdgesAndVerticesCrossAsOften) {
  // An octahedron with its corners on lattice columns, off the lattice only in z.
  TriangleMesh mesh;
  for (const double shift : {0.0, 0.25, 0.5}) {
    mesh.vertices = {{6, 0, shift},  {-6, 0, shift},      {0, 6, shift},
                     {0, -6, shift}, {0, 0, 6.5 + shift}, {0, 0, -6.5 + shift}};
    mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                      {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    const auto frame = occupancy(mesh, {}, 0);
    ASSERT_TRUE(frame);
    for (int x = -9; x <= 9; ++x) {
      for (int y = -9; y <= 9; ++y) {
        for (int z = -9; z <= 9; ++z) {
          const double level = (std::abs(x) + std::abs(y)) / 6.0 + std::abs(z - shift) / 6.5;
          ASSERT_EQ(isInside(*frame, x, y, z), level < 1 - 1e-12) << x << " " << y << " " << z;
        }
      }
    }
  }
}

TEST(Occupancy, BlocksAndTilesAreInOrderAndMixedAreBlocks) {
  const auto frame = occupancy(fixtures::icosphere(40, 3), {}, 2.5);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->time, 2.5);
  EXPECT_FALSE(frame->hasValues());
  EXPECT_GT(frame->tiles.size(), 100U);
  for (std::size_t i = 1; i < frame->blocks.size(); ++i) {
    EXPECT_LT(frame->blocks[i - 1].coord, frame->blocks[i].coord);
  }
  for (std::size_t i = 1; i < frame->tiles.size(); ++i) {
    EXPECT_LT(frame->tiles[i - 1].coord, frame->tiles[i].coord);
  }
}

TEST(Occupancy, IsTheSameForAnyNumberOfThreads) {
  const auto mesh = posed(fixtures::boltWithThread(), turned(12, {1, 1, 0}, {0.1, 0.2, 0.3}));
  const auto run = [&](std::size_t threads) {
    const model::ThreadLimit limit(threads);
    return *occupancy(mesh, {0.3, Point3::Zero()}, 0);
  };
  const Frame one = run(1);
  const Frame many = run(8);
  ASSERT_EQ(one.blocks.size(), many.blocks.size());
  ASSERT_EQ(one.tiles.size(), many.tiles.size());
  for (std::size_t i = 0; i < one.blocks.size(); ++i) {
    EXPECT_EQ(one.blocks[i].coord, many.blocks[i].coord);
    EXPECT_EQ(one.blocks[i].inside, many.blocks[i].inside);
  }
}

TEST(Occupancy, EmptyMeshIsAnEmptyFrame) { EXPECT_EQ(countInside({}), 0U); }

TEST(Occupancy, RefusesWhatBoundsNothing) {
  TriangleMesh open = fixtures::cube(20);
  open.triangles.pop_back();
  EXPECT_NE(refusal(open).find("open: 3 boundary edges"), std::string::npos) << refusal(open);
  TriangleMesh broken = fixtures::cube(20);
  broken.vertices[3].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(refusal(broken).find("must be finite"), std::string::npos) << refusal(broken);
  TriangleMesh index = fixtures::cube(20);
  index.triangles[0][0] = 99;
  EXPECT_NE(refusal(index).find("99"), std::string::npos) << refusal(index);
}

TEST(Occupancy, RefusesVoxelsThatAreNoneOrTooMany) {
  const auto cube = fixtures::cube(20);
  EXPECT_EQ(refusal(cube, {0, Point3::Zero()}),
            "voxels of 0 are requested; 1e-30 to 1e+30 are possible");
  EXPECT_EQ(refusal(cube, {-1, Point3::Zero()}),
            "voxels of -1 are requested; 1e-30 to 1e+30 are possible");
  EXPECT_NE(refusal(cube, {std::nan(""), Point3::Zero()}).find("voxels of nan are requested"),
            std::string::npos);
  EXPECT_EQ(refusal(cube, {0.001, Point3::Zero()}),
            "with a voxel size of 0.001 the solid takes 20001 x 20001 x 20001 voxels (8e+12); at "
            "most 6.87e+10 are allowed: use larger voxels");
  const auto far = posed(cube, {Eigen::Matrix3d::Identity(), {1e9, 0, 0}});
  EXPECT_NE(refusal(far).find("1e+09 voxels from the lattice's origin"), std::string::npos)
      << refusal(far);
}

}  // namespace
}  // namespace t4d::voxel4d
