#include "voxel4d/union_surface.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "measure/winding_number.h"
#include "t4d/weave.h"
#include "voxel4d/convex_pieces.h"
#include "voxel4d/occupancy.h"
#include "voxel4d/vdb_grid.h"

namespace t4d::voxel4d {
namespace {

using model::Point3;
using model::Triangle;
using model::TriangleMesh;

constexpr double kTolerance = 1e-10;

void add(TriangleMesh& mesh, const TriangleMesh& other) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const auto& [a, b, c] : other.triangles) {
    mesh.triangles.push_back({first + a, first + b, first + c});
  }
}

TriangleMesh movedBy(TriangleMesh mesh, const Eigen::Matrix3d& rotation, const Point3& shift) {
  for (Point3& vertex : mesh.vertices) vertex = rotation * vertex + shift;
  return mesh;
}

UnionSurface partsOf(const TriangleMesh& mesh) {
  return unionSurface(mesh.vertices, mesh.triangles, kTolerance);
}

double areaOf(const UnionSurface& parts, const std::vector<Triangle>& triangles) {
  return surfaceArea(TriangleMesh{parts.points, triangles, {}});
}

/// Boxes of whole cells of a lattice of kCells^3, and the cells that they cover.
struct Boxes {
  static constexpr int kCells = 7;

  explicit Boxes(std::uint64_t seed) {
    std::mt19937_64 random(seed);
    const auto number = [&](int most) { return static_cast<int>(random() % (most + 1)); };
    const int count = 2 + number(4);
    for (int i = 0; i < count; ++i) {
      Eigen::Vector3i low;
      Eigen::Vector3i size;
      for (int axis = 0; axis < 3; ++axis) {
        low[axis] = number(kCells - 2);
        size[axis] = 1 + number(std::min(3, kCells - 1 - low[axis]));
      }
      const Eigen::Vector3i high = low + size;
      add(mesh, movedBy(fixtures::cube(1), size.cast<double>().asDiagonal(),
                        (low + high).cast<double>() / 2));
      for (int x = low.x(); x < high.x(); ++x) {
        for (int y = low.y(); y < high.y(); ++y) {
          for (int z = low.z(); z < high.z(); ++z) covered.insert({x, y, z});
        }
      }
    }
  }

  /// Whether a point, in units of half a cell, is in the interior of the union.
  bool holds(int x, int y, int z) const {
    for (int corner = 0; corner < 8; ++corner) {
      // The cells on either side of the point; along an axis in whose middle it is, one.
      const auto cell = [](int at, bool upper) { return (at - (upper ? 0 : 1)) >> 1; };
      const Coord near = {cell(x, (corner & 1) != 0), cell(y, (corner & 2) != 0),
                          cell(z, (corner & 4) != 0)};
      if (!covered.contains(near)) return false;
    }
    return true;
  }

  /// The distance from the boundary of the union: the faces between covered and other cells.
  double distanceFrom(const Point3& point) const {
    double best = std::numeric_limits<double>::infinity();
    for (const auto& [x, y, z] : covered) {
      const std::array<int, 3> cell = {x, y, z};
      for (int axis = 0; axis < 3; ++axis) {
        for (const int side : {0, 1}) {
          std::array<int, 3> next = cell;
          next[axis] += side == 0 ? -1 : 1;
          if (covered.contains({next[0], next[1], next[2]})) continue;
          Point3 low(x, y, z);
          Point3 high = low + Point3::Ones();
          low[axis] = high[axis] = cell[axis] + side;
          best = std::min(best, (low - point).cwiseMax(point - high).cwiseMax(0).norm());
        }
      }
    }
    return best;
  }

  TriangleMesh mesh;
  std::set<Coord> covered;
};

TEST(UnionSurface, OfASolidThatDoesNotMeetItselfIsItsOwn) {
  for (const auto& solid : fixtures::allSolids()) {
    const UnionSurface parts = partsOf(solid.mesh);
    EXPECT_EQ(parts.outer, solid.mesh.triangles) << solid.name;
    EXPECT_TRUE(parts.inner.empty()) << solid.name;
  }
}

TEST(UnionSurface, SolidsInsideOthersAreWithinAndCavitiesAreNot) {
  TriangleMesh mesh = fixtures::icosphere(10, 2);
  const std::size_t ofBall = mesh.triangles.size();
  add(mesh, fixtures::cube(3));
  const UnionSurface parts = partsOf(mesh);
  EXPECT_EQ(parts.outer.size(), ofBall);
  EXPECT_EQ(parts.inner.size(), 12U);
  EXPECT_TRUE(partsOf(fixtures::hollowCube(20, 10)).inner.empty());
}

TEST(UnionSurface, FacesAlongWhichSolidsTouchAreWithin) {
  TriangleMesh mesh = fixtures::cube(2);
  add(mesh, movedBy(fixtures::cube(2), Eigen::Matrix3d::Identity(), {2, 1, 0}));
  const UnionSurface parts = partsOf(mesh);
  EXPECT_NEAR(areaOf(parts, parts.inner), 2 * 2, 1e-12);
  EXPECT_NEAR(areaOf(parts, parts.outer), 48 - 2 * 2, 1e-12);
  // Edges and corners alone bound both.
  for (const Point3& shift : {Point3(2, 2, 0), Point3(2, 2, 2)}) {
    TriangleMesh apart = fixtures::cube(2);
    add(apart, movedBy(fixtures::cube(2), Eigen::Matrix3d::Identity(), shift));
    EXPECT_TRUE(partsOf(apart).inner.empty()) << shift.transpose();
  }
}

TEST(UnionSurface, SidesOfPartsAreWhatWindingNumbersSay) {
  const std::vector<TriangleMesh> solids = {fixtures::cube(8), fixtures::icosphere(5, 2),
                                            fixtures::torus(5, 2, 24, 12),
                                            fixtures::hollowCube(9, 4), fixtures::bipyramid(40)};
  std::mt19937_64 random(7);
  const auto number = [&] { return static_cast<double>(random() >> 11U) / 0x1p53 - 0.5; };
  for (int trial = 0; trial < 12; ++trial) {
    TriangleMesh mesh;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d axis(number(), number(), number());
      const Eigen::Matrix3d rotation =
          Eigen::AngleAxisd(6 * number(), axis.normalized()).toRotationMatrix();
      add(mesh, movedBy(solids[random() % solids.size()], rotation,
                        8 * Point3(number(), number(), number())));
    }
    const UnionSurface parts = partsOf(mesh);
    EXPECT_NEAR(areaOf(parts, parts.outer) + areaOf(parts, parts.inner), surfaceArea(mesh), 1e-6);
    const measure::WindingNumber winding(mesh);
    int checked = 0;
    const auto check = [&](const Triangle& triangle, bool within) {
      const Point3& a = parts.points[triangle[0]];
      const Point3& b = parts.points[triangle[1]];
      const Point3& c = parts.points[triangle[2]];
      const Point3 normal = (b - a).cross(c - a);
      const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
      constexpr double kStep = 1e-6;
      if (normal.norm() < 100 * kStep * longest) return;  // too narrow to look beside it
      const Point3 centre = (a + b + c) / 3;
      const auto at = [&](double side) {
        return std::lround(winding.exactAt(centre + side * kStep * normal.normalized()));
      };
      const bool above = at(1) == 0;
      const bool below = at(-1) == 0;
      EXPECT_EQ(!above && !below, within) << "trial " << trial << " at " << centre.transpose();
      ++checked;
    };
    for (std::size_t i = 0; i < parts.outer.size(); i += 7) check(parts.outer[i], false);
    for (std::size_t i = 0; i < parts.inner.size(); i += 7) check(parts.inner[i], true);
    EXPECT_GT(checked, 20);
  }
}

TEST(UnionSurface, InsidePointsOfBoxesOnTheLatticeAreThoseOfTheirUnion) {
  // Steps of 0.1 are rounded, as are poses by quarter turns.
  const Eigen::Matrix3d turned =
      Eigen::AngleAxisd(std::numbers::pi / 2, Point3::UnitZ()).toRotationMatrix() *
      Eigen::AngleAxisd(std::numbers::pi / 2, Point3::UnitX()).toRotationMatrix();
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const Boxes boxes(seed);
    for (const double cell : {1.0, 0.2}) {
      const Lattice lattice{cell / 2, Point3::Zero()};
      const TriangleMesh scaled =
          movedBy(boxes.mesh, cell * Eigen::Matrix3d::Identity(), Point3::Zero());
      const auto frame = occupancy(scaled, lattice, 0);
      const auto there = occupancy(movedBy(scaled, turned, Point3(cell, 0, 7 * cell)), lattice, 0);
      ASSERT_TRUE(frame && there);
      std::uint64_t inside = 0;
      for (int x = 0; x <= 2 * Boxes::kCells; ++x) {
        for (int y = 0; y <= 2 * Boxes::kCells; ++y) {
          for (int z = 0; z <= 2 * Boxes::kCells; ++z) {
            const bool found =
                (insideOf(*frame, {x >> 3, y >> 3, z >> 3})[x & 7] >> (8 * (y & 7) + (z & 7)) &
                 1U) != 0;
            ASSERT_EQ(found, boxes.holds(x, y, z))
                << "seed " << seed << " at " << x << " " << y << " " << z;
            inside += found ? 1 : 0;
          }
        }
      }
      EXPECT_EQ(countInside(*frame), inside) << seed;
      EXPECT_EQ(countInside(*there), inside) << seed;
    }
  }
}

TEST(UnionSurface, LevelSetsOfBoxesAreDistancesFromTheirUnion) {
  initializeOpenVdb();
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Boxes boxes(seed);
    const Lattice lattice{0.5, Point3::Zero()};
    const auto occupancy = occupancyOf(boxes.mesh, lattice, 0);
    ASSERT_TRUE(occupancy);
    const auto grid = levelSetOf(*occupancy, lattice);
    const auto value = grid->getConstAccessor();
    for (int x = -2; x <= 2 * Boxes::kCells + 2; ++x) {
      for (int y = -2; y <= 2 * Boxes::kCells + 2; ++y) {
        for (int z = -2; z <= 2 * Boxes::kCells + 2; ++z) {
          const double distance = boxes.distanceFrom(Point3(x, y, z) / 2);
          const double expected = boxes.holds(x, y, z) ? -distance : distance;
          const double found = value.getValue({x, y, z});
          if (distance < 2 * lattice.voxelSize) {
            ASSERT_NEAR(found, expected, 1e-6) << seed << ": " << x << " " << y << " " << z;
          } else {
            ASSERT_EQ(found < 0, expected < 0) << seed << ": " << x << " " << y << " " << z;
            ASSERT_GE(std::abs(found), 2 * lattice.voxelSize - 1e-6) << seed;
          }
        }
      }
    }
  }
}

/// A bar, two wide, around a square of 10: one component. It ends in the plane y = `end`, where it
/// may run into its beginning, which is in the plane x = 0.
TriangleMesh bentBar(double end) {
  const std::vector<std::array<Eigen::Vector2d, 2>> sections = {{{{0, 1}, {0, -1}}},
                                                                {{{9, 1}, {11, -1}}},
                                                                {{{9, 9}, {11, 11}}},
                                                                {{{1, 9}, {-1, 11}}},
                                                                {{{1, end}, {-1, end}}}};
  TriangleMesh bar;
  for (const auto& [inner, outer] : sections) {
    for (const auto& [at, z] : {std::pair(inner, -1), {outer, -1}, {outer, 1}, {inner, 1}}) {
      bar.vertices.emplace_back(at.x(), at.y(), z);
    }
  }
  const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    bar.triangles.push_back({a, b, c});
    bar.triangles.push_back({a, c, d});
  };
  for (std::uint32_t section = 0; section < 4; ++section) {
    for (std::uint32_t i = 0; i < 4; ++i) {
      const std::uint32_t next = (i + 1) % 4;
      quad(4 * section + i, 4 * section + next, 4 * section + 4 + next, 4 * section + 4 + i);
    }
  }
  quad(3, 2, 1, 0);
  quad(16, 17, 18, 19);
  return bar;
}

TEST(UnionSurface, AComponentMayOverlapOrTouchItself) {
  // The end is in the bar, closer to its side than columns are to each other, on it, and apart.
  for (const double end : {0.0, 0.75, 1.0, 1.5}) {
    const auto isIn = [&](double x, double y) {
      const auto within = [&](double left, double right, double low, double high) {
        return x >= left && x <= right && y >= low && y <= high;
      };
      return within(0, 11, -1, 1) || within(9, 11, -1, 11) || within(-1, 11, 9, 11) ||
             within(-1, 1, end, 11);
    };
    ASSERT_TRUE(model::isClosed(bentBar(end)));
    const auto frame = occupancy(bentBar(end), {0.5, Point3::Zero()}, 0);
    ASSERT_TRUE(frame);
    std::uint64_t inside = 0;
    for (int x = -4; x <= 24; ++x) {
      for (int y = -4; y <= 24; ++y) {
        constexpr double kNear = 1e-6;
        const double a = x / 2.0;
        const double b = y / 2.0;
        const bool expected = isIn(a - kNear, b - kNear) && isIn(a + kNear, b - kNear) &&
                              isIn(a - kNear, b + kNear) && isIn(a + kNear, b + kNear);
        const BlockMask mask = insideOf(*frame, {x >> 3, y >> 3, 0});
        ASSERT_EQ((mask[x & 7] >> (8 * (y & 7)) & 1U) != 0, expected)
            << "end " << end << " at " << a << " " << b;
        inside += expected ? 3 : 0;  // z = -0.5, 0 and 0.5
      }
    }
    EXPECT_EQ(countInside(*frame), inside) << end;
  }
}

TEST(UnionSurface, PiecesOfAPolygonFillIt) {
  std::mt19937_64 random(3);
  const auto number = [&] { return static_cast<double>(random() >> 11U) / 0x1p53; };
  const ConvexPolygon triangle = {{0, 0}, {1, 0}, {0, 1}};
  std::vector<PlaneSegment> segments;
  for (int i = 0; i < 30; ++i) {
    segments.push_back({{number(), number()}, {number(), number()}});
  }
  const auto pieces = cutAlong(triangle, segments, kTolerance, 10'000);
  double area = 0;
  for (const ConvexPolygon& piece : pieces) {
    for (std::size_t i = 0; i < piece.size(); ++i) {
      const Eigen::Vector2d& a = piece[i];
      const Eigen::Vector2d& b = piece[(i + 1) % piece.size()];
      area += (a.x() * b.y() - a.y() * b.x()) / 2;
    }
    for (const PlaneSegment& segment : segments) {
      const auto inside = within(piece, segment, kTolerance);
      EXPECT_FALSE(inside && isCut(piece, *inside, kTolerance));
    }
  }
  EXPECT_NEAR(area, 0.5, 1e-9);
  EXPECT_EQ(cutAlong(triangle, {}, kTolerance, 10).size(), 1U);
  EXPECT_LE(cutAlong(triangle, segments, kTolerance, 10).size(), 12U);
}

}  // namespace
}  // namespace t4d::voxel4d
