/// What is measured of a mesh that is scaled by a power of two is the measure, scaled, exactly: at
/// sizes from 1e-140 to 1e140.
#include <array>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "measure/collision_verdict.h"
#include "measure/slab_measure.h"
#include "measure/triangle_tree.h"
#include "measure/winding_number.h"
#include "t4d/check.h"
#include "t4d/collide.h"
#include "t4d/sweep.h"

namespace t4d::measure {
namespace {

using model::Mesh;
using model::Point3;
using model::Point4;
using model::TriangleMesh;

constexpr std::array<int, 8> kExponents = {-465, -250, -190, -70, 70, 180, 240, 465};

TriangleMesh scaled(TriangleMesh mesh, int exponent) {
  for (Point3& vertex : mesh.vertices) vertex *= std::ldexp(1.0, exponent);
  return mesh;
}

Mesh scaled(const Mesh& mesh, int space, int time) {
  Mesh made;
  for (model::Slab slab : mesh.slabs()) {
    slab.upperPose = nullptr;
    slab.timeBegin = std::ldexp(slab.timeBegin, time);
    slab.timeEnd = std::ldexp(slab.timeEnd, time);
    for (Point4& vertex : slab.vertices) {
      vertex.head<3>() *= std::ldexp(1.0, space);
      vertex[3] = std::ldexp(vertex[3], time);
    }
    EXPECT_TRUE(made.put(slab));
  }
  return made;
}

Mesh moving(const TriangleMesh& mesh, const Point3& by, double degrees) {
  model::ScrewRun run{2, {}, 1};
  run.screw.translation = by;
  run.screw.axisDirection = Point3(1, 2, 2) / 3;
  run.screw.angleDegrees = degrees;
  const auto motion = model::chainScrews(0, {&run, 1});
  Mesh made;
  const auto report = mesh4d::sweep(mesh, *motion, {.steps = mesh4d::StepsPerSegment{3}}, made);
  EXPECT_TRUE(report) << report.error().text();
  return made;
}

TEST(Scale, CollisionsAreTheScaledCollisions) {
  const Mesh a = scaled(moving(fixtures::cube(2), {3, 0, 0}, 40), 0, 0);
  for (const Point3& at : {Point3(4, 0.5, 0), Point3(7.5, 0.2, 0.1), Point3(0.1, 0.1, 0.2)}) {
    const Mesh b =
        scaled(moving(fixtures::translated(fixtures::cube(1), at), {-0.5, 0, 0}, 10), 0, 0);
    const CollideOptions options{.clearance = true, .clearanceOverTime = true};
    const auto expected = collide(a, b, options);
    ASSERT_TRUE(expected);
    const auto verdict = verdictOn(*expected, a, b);
    ASSERT_TRUE(verdict);
    for (const int exponent : {-465, 190}) {
      const int time = exponent / 3;
      const Mesh p = scaled(a, exponent, time);
      const Mesh q = scaled(b, exponent, time);
      const auto found = collide(p, q, options);
      ASSERT_TRUE(found) << found.error().text();
      ASSERT_EQ(found->intervals.size(), expected->intervals.size()) << exponent;
      for (std::size_t i = 0; i < found->intervals.size(); ++i) {
        const ContactInterval& one = found->intervals[i];
        const ContactInterval& wanted = expected->intervals[i];
        EXPECT_EQ(one.begin, std::ldexp(wanted.begin, time));
        EXPECT_EQ(one.end, std::ldexp(wanted.end, time));
        EXPECT_EQ(one.overlaps, wanted.overlaps);
        EXPECT_EQ(one.first.point, wanted.first.point * std::ldexp(1.0, exponent));
        EXPECT_EQ(one.overlapVolume, std::ldexp(wanted.overlapVolume, 3 * exponent)) << exponent;
      }
      ASSERT_EQ(found->clearance.has_value(), expected->clearance.has_value());
      if (found->clearance) {
        EXPECT_EQ(found->clearance->distance, std::ldexp(expected->clearance->distance, exponent));
        EXPECT_EQ(found->clearance->time, std::ldexp(expected->clearance->time, time));
      }
      ASSERT_EQ(found->clearanceOverTime.size(), expected->clearanceOverTime.size());
      const auto said = verdictOn(*found, p, q);
      ASSERT_TRUE(said);
      EXPECT_EQ(said->verdict, verdict->verdict) << exponent;
      EXPECT_NEAR(std::ldexp(said->depth, -exponent), verdict->depth, 0.03 * verdict->depth);
      EXPECT_EQ(said->clearBy, std::ldexp(verdict->clearBy, exponent));
    }
  }
}

TEST(Scale, ComparisonsOfSolidsAreTheScaledComparisons) {
  const TriangleMesh a = fixtures::torus(3, 1, 24, 12);
  const TriangleMesh b = fixtures::translated(fixtures::torus(3, 1, 20, 16), {0.1, 0.05, 0.02});
  const auto expected = compareSolids(1, a, b);
  ASSERT_TRUE(expected);
  for (const int exponent : kExponents) {
    const auto of = [&](double value, int power) { return std::ldexp(value, power * exponent); };
    const TriangleMesh p = scaled(a, exponent);
    const TriangleMesh q = scaled(b, exponent);
    const auto found = compareSolids(1, p, q);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->volumeA, of(expected->volumeA, 3)) << exponent;
    EXPECT_EQ(found->areaB, of(expected->areaB, 2)) << exponent;
    EXPECT_EQ(found->difference.volume, of(expected->difference.volume, 3)) << exponent;
    EXPECT_EQ(found->distance.fromA, of(expected->distance.fromA, 1)) << exponent;
    EXPECT_EQ(found->distance.fromB, of(expected->distance.fromB, 1)) << exponent;
    const auto near = fartherThan(of(0.5, 1), p, q);
    ASSERT_TRUE(near);
    EXPECT_FALSE(*near) << exponent;
    const auto far = fartherThan(of(0.01, 1), p, q);
    ASSERT_TRUE(far && *far);
    EXPECT_GT(**far, of(0.01, 1));
  }
}

TEST(Scale, DistancesAndWindingNumbersAreThoseOfTheUnit) {
  const TriangleMesh mesh = fixtures::torus(3, 1, 24, 12);
  const TriangleTree tree(mesh);
  const WindingNumber winding(mesh);
  for (const int exponent : kExponents) {
    const TriangleTree scaledTree(scaled(mesh, exponent));
    const WindingNumber scaledWinding(scaled(mesh, exponent));
    for (const Point3& point : {Point3(3, 0.2, 0.1), Point3(0, 0, 0), Point3(9, 8, 7)}) {
      const Point3 there = point * std::ldexp(1.0, exponent);
      EXPECT_EQ(scaledTree.nearest(there).distance,
                std::ldexp(tree.nearest(point).distance, exponent));
      EXPECT_EQ(scaledWinding.at(there), winding.at(point));
      EXPECT_EQ(scaledWinding.exactAt(there), winding.exactAt(point));
    }
  }
}

TEST(Scale, MeshesAreValidAtAnySize) {
  const Mesh mesh = moving(fixtures::torus(3, 1, 12, 8), {1, 2, 3}, 50);
  const auto expected = checkMesh(mesh);
  ASSERT_TRUE(expected && expected->valid());
  for (const int space : kExponents) {
    for (const int time : {-465, 0, 465}) {
      const auto found = checkMesh(scaled(mesh, space, time));
      ASSERT_TRUE(found);
      EXPECT_TRUE(found->valid()) << found->issues.issues.front().message;
      EXPECT_EQ(found->degenerateCells, 0U) << space << " " << time;
      const double wanted = std::ldexp(expected->hypervolume, 3 * space + time);
      // Slab by slab it is rounded where it is denormal.
      if (std::isfinite(wanted) && wanted > 1e-290) {
        EXPECT_EQ(found->hypervolume, wanted) << space << " " << time;
      }
    }
  }
}

TEST(Scale, QualityIsTheSameAtAnySize) {
  const Mesh mesh = moving(fixtures::torus(3, 1, 12, 8), {1, 2, 3}, 50);
  const model::Body body{"a", &mesh};
  const auto speed = meanNormalSpeed({&body, 1});
  ASSERT_TRUE(speed);
  const auto expected = measureQuality({&body, 1}, {.timeScale = *speed});
  ASSERT_TRUE(expected);
  for (const int exponent : kExponents) {
    const Mesh other = scaled(mesh, exponent, 0);
    const model::Body otherBody{"a", &other};
    const auto otherSpeed = meanNormalSpeed({&otherBody, 1});
    ASSERT_TRUE(otherSpeed);
    EXPECT_EQ(*otherSpeed, std::ldexp(*speed, exponent));
    const auto found = measureQuality({&otherBody, 1}, {.timeScale = *otherSpeed});
    ASSERT_TRUE(found);
    EXPECT_EQ(found->flat, expected->flat);
    for (std::size_t k = 1; k < kQualityMeasures.size(); ++k) {
      const double wanted = expected->all(k).quantile(0.5);
      EXPECT_NEAR(found->all(k).quantile(0.5), wanted, 1e-9 * wanted) << exponent << " " << k;
    }
  }
}

/// The sides of a simplex with the corners 0 to 4, all facing outward or all inward.
std::vector<model::Cell> sidesOfSimplex() {
  std::vector<model::Cell> cells;
  for (std::uint32_t out = 0; out < 5; ++out) {
    model::Cell cell{};
    for (std::uint32_t i = 0, k = 0; i < 5; ++i) {
      if (i != out) cell[k++] = i;
    }
    if (out % 2 == 1) std::swap(cell[2], cell[3]);
    cells.push_back(cell);
  }
  return cells;
}

TEST(HypervolumeSign, OfAShellThinnerThanRoundingIsExact) {
  // A simplex, and the same inside out but for a corner that is moved by one unit in the last
  // place.
  std::mt19937 random(11);
  std::uniform_real_distribution<double> number(1000, 2000);
  const std::vector<model::Cell> sides = sidesOfSimplex();
  for (int trial = 0; trial < 300; ++trial) {
    std::vector<Point4> points(5);
    for (Point4& point : points) {
      for (double& coordinate : point) coordinate = number(random);
    }
    std::vector<model::Cell> cells = sides;
    if (hypervolumeSign(points, cells) < 0) {
      for (model::Cell& cell : cells) std::swap(cell[2], cell[3]);
    }
    // The volume changes by the step times a determinant of the opposite side.
    Eigen::Matrix3d side;
    for (int k = 0; k < 3; ++k) side.row(k) = (points[k + 1] - points[0]).tail<3>();
    const Point4 apart = points[4] - points[0];
    Eigen::Matrix4d whole;
    for (int k = 0; k < 3; ++k) whole.row(k) = points[k + 1] - points[0];
    whole.row(3) = apart;
    if (std::abs(side.determinant()) < 1e6 || std::abs(whole.determinant()) < 1e9) continue;
    const double outward = -side.determinant() / whole.determinant() > 0 ? 1 : -1;
    const auto inner = cells;
    for (int i = 0; i < 5; ++i) points.push_back(points[i]);
    points[9].x() = std::nextafter(points[9].x(), 1e9);
    for (model::Cell cell : inner) {
      for (std::uint32_t& corner : cell) corner += 5;
      std::swap(cell[2], cell[3]);
      cells.push_back(cell);
    }
    EXPECT_EQ(hypervolumeSign(points, cells), -outward) << trial;
  }
}

TEST(CheckMesh, AnInfiniteHypervolumeStaysInfinite) {
  MeshChecker checker;
  const std::vector<model::Cell> sides = sidesOfSimplex();
  for (const double size : {1e120, 1.0}) {
    auto connectivity = std::make_shared<model::Connectivity>();
    connectivity->vertexCount = 5;
    connectivity->cells = sides;
    model::Slab slab;
    slab.timeBegin = size == 1 ? 1e120 : 0;
    slab.timeEnd = size == 1 ? 2e120 : 1e120;
    slab.connectivity = connectivity;
    slab.vertices.push_back({0, 0, 0, slab.timeBegin});
    for (int axis = 0; axis < 3; ++axis) {
      slab.vertices.emplace_back(size * Point4::Unit(axis));
      slab.vertices.back().w() = slab.timeBegin;
    }
    slab.vertices.push_back({0, 0, 0, slab.timeEnd});
    ASSERT_TRUE(checker.put(slab));
  }
  EXPECT_TRUE(std::isinf(checker.finish().hypervolume));
}

TEST(HypervolumeSign, IsExactWhateverTheCoordinates) {
  // The simplex with corners at the origin and on the axes.
  std::vector<Point4> points = {Point4::Zero()};
  for (int axis = 0; axis < 4; ++axis) points.emplace_back(Point4::Unit(axis));
  std::vector<model::Cell> cells = sidesOfSimplex();
  if (hypervolumeSign(points, cells) < 0) {
    for (model::Cell& cell : cells) std::swap(cell[2], cell[3]);
  }
  ASSERT_EQ(hypervolumeSign(points, cells), 1);
  for (const double far : {1e20, 1e70, 1e150, 1e300}) {
    for (std::size_t moved = 0; moved < 5; ++moved) {
      // Along the direction in which the opposite side lies, the volume stays what it is.
      std::vector<Point4> other = points;
      const std::size_t a = (moved + 1) % 5;
      const std::size_t b = (moved + 2) % 5;
      other[moved] += far * (points[a] - points[b]);
      EXPECT_EQ(hypervolumeSign(other, cells), 1) << far << " " << moved;
      auto turned = cells;
      for (model::Cell& cell : turned) std::swap(cell[2], cell[3]);
      EXPECT_EQ(hypervolumeSign(other, turned), -1) << far << " " << moved;
    }
  }
  for (Point4& point : points) point *= 1e-300;
  EXPECT_EQ(hypervolumeSign(points, cells), 1);
}

}  // namespace
}  // namespace t4d::measure
