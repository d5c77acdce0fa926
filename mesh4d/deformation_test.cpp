#include <cmath>
#include <random>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "mesh4d/folds.h"
#include "t4d/check.h"
#include "t4d/slice.h"
#include "t4d/sweep.h"

namespace t4d::mesh4d {
namespace {

using model::Point3;
using model::StoredKeys;
using model::TriangleMesh;

constexpr SweepOptions kCones{{}, CapMethod::Cone, PrismSplit::Fourteen, {}};

TriangleMesh withVertices(TriangleMesh mesh, const std::vector<Point3>& vertices) {
  mesh.vertices = vertices;
  return mesh;
}

/// A solid bent about z and swollen, more from key to key, at uneven times.
std::vector<StoredKeys::Key> bend(const TriangleMesh& mesh, std::size_t count) {
  std::vector<StoredKeys::Key> keys;
  for (std::size_t k = 0; k < count; ++k) {
    const auto amount = static_cast<double>(k);
    StoredKeys::Key key{amount + 0.1 * amount * amount, {}};
    for (const Point3& p : mesh.vertices) {
      const double angle = 0.05 * amount * p.x();
      key.positions.emplace_back(p.x() * std::cos(angle) - p.y() * std::sin(angle),
                                 p.x() * std::sin(angle) + p.y() * std::cos(angle),
                                 p.z() * (1 + 0.1 * amount));
    }
    keys.push_back(std::move(key));
  }
  return keys;
}

double volumeBetween(const TriangleMesh& mesh, const StoredKeys::Key& from,
                     const StoredKeys::Key& to, double s) {
  TriangleMesh between = mesh;
  for (std::size_t i = 0; i < between.vertices.size(); ++i) {
    between.vertices[i] = (1 - s) * from.positions[i] + s * to.positions[i];
  }
  return signedVolume(between);
}

/// The oracle for any corresponding vertices (Simpson's rule is exact for a cubic).
double hypervolumeOf(const TriangleMesh& mesh, const std::vector<StoredKeys::Key>& keys) {
  double sum = 0;
  for (std::size_t k = 0; k + 1 < keys.size(); ++k) {
    const auto volume = [&](double s) { return volumeBetween(mesh, keys[k], keys[k + 1], s); };
    sum += (keys[k + 1].time - keys[k].time) * (volume(0) + 4 * volume(0.5) + volume(1)) / 6;
  }
  return sum;
}

TEST(Deformation, EnclosesTheHypervolumeOfTheInterpolatedSolids) {
  for (const TriangleMesh& solid :
       {fixtures::paperCube(2), fixtures::torus(2, 1, 12, 8), fixtures::hollowCube(4, 2)}) {
    const auto keys = bend(solid, 6);
    model::Mesh swept;
    const auto report = sweep(solid, StoredKeys(keys), kCones, swept);
    ASSERT_TRUE(report) << report.error().text();
    EXPECT_EQ(report->steps, 5U);
    EXPECT_EQ(report->foldedPrisms, 0U);
    const auto judged = *measure::checkMesh(swept);
    EXPECT_TRUE(judged.closed && judged.oriented && judged.valid());
    EXPECT_NEAR(judged.hypervolume / hypervolumeOf(solid, keys), 1, 1e-13);
    const std::size_t v = solid.vertices.size();
    const std::size_t f = solid.triangles.size();
    EXPECT_EQ(report->vertices, 6 * v + 5 * (3 * f / 2 + f) + 2);
    EXPECT_EQ(report->tetrahedra, 14 * f * 5 + 2 * f);
  }
}

TEST(Deformation, HoldsForPositionsAtRandom) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-1, 1);
  const TriangleMesh solid = fixtures::icosphere(2, 1);
  std::vector<StoredKeys::Key> keys;
  for (int k = 0; k < 5; ++k) {
    StoredKeys::Key key{std::sqrt(k), solid.vertices};
    for (Point3& p : key.positions) p += 2 * Point3(number(random), number(random), number(random));
    keys.push_back(std::move(key));
  }
  if (signedVolume(withVertices(solid, keys[0].positions)) < 0) {
    for (auto& key : keys) {
      for (Point3& p : key.positions) p = -p;
    }
  }
  model::Mesh swept;
  const auto report = sweep(solid, StoredKeys(keys), kCones, swept);
  ASSERT_TRUE(report) << report.error().text();
  const auto judged = *measure::checkMesh(swept);
  EXPECT_TRUE(judged.closed && judged.oriented);
  EXPECT_NEAR(judged.hypervolume, hypervolumeOf(solid, keys), 1e-12);
  EXPECT_GT(report->foldedPrisms, 0U);
}

TEST(Deformation, SlicesAtKeysAreTheSolidsAndBetweenHaveTheirVolume) {
  const TriangleMesh solid = fixtures::torus(2, 1, 12, 8);
  const auto keys = bend(solid, 4);
  model::Mesh swept;
  ASSERT_TRUE(sweep(solid, StoredKeys(keys), kCones, swept));
  for (std::size_t k = 0; k < keys.size(); ++k) {
    const auto slice = slice::sliceAtTime(swept, keys[k].time);
    ASSERT_TRUE(slice);
    ASSERT_EQ(slice->mesh.triangles.size(), solid.triangles.size());
    const auto less = [](const Point3& a, const Point3& b) {
      return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
    };
    auto found = slice->mesh.vertices;
    auto expected = keys[k].positions;
    std::sort(found.begin(), found.end(), less);
    std::sort(expected.begin(), expected.end(), less);
    EXPECT_EQ(found, expected);
    if (k + 1 == keys.size()) continue;
    for (const double s : {0.125, 0.5, 0.8}) {
      const double time = keys[k].time + s * (keys[k + 1].time - keys[k].time);
      const auto between = slice::sliceAtTime(swept, time);
      EXPECT_TRUE(isClosed(between->mesh));
      EXPECT_NEAR(signedVolume(between->mesh), volumeBetween(solid, keys[k], keys[k + 1], s),
                  1e-12);
    }
  }
}

TEST(Deformation, PartsAreTheWhole) {
  const TriangleMesh solid = fixtures::cube(2);
  const auto keys = bend(solid, 6);
  model::Mesh whole;
  ASSERT_TRUE(sweep(solid, StoredKeys(keys), kCones, whole));
  model::Mesh parts;
  for (std::uint64_t part = 1; part <= 3; ++part) {
    SweepOptions options = kCones;
    options.part = {part, 3};
    ASSERT_TRUE(sweep(solid, StoredKeys(keys), options, parts));
  }
  ASSERT_EQ(parts.slabCount(), whole.slabCount());
  for (std::size_t i = 0; i < parts.slabCount(); ++i) {
    EXPECT_EQ(parts.slabs()[i].vertices, whole.slabs()[i].vertices);
  }
}

/// The two keys of a solid and an image of it, swept.
template <class Map>
Result<SweepReport> sweptTo(const TriangleMesh& solid, const Map& map) {
  std::vector<StoredKeys::Key> keys{{0, solid.vertices}, {1, solid.vertices}};
  for (Point3& p : keys[1].positions) p = map(p);
  model::Mesh swept;
  return sweep(solid, StoredKeys(keys), kCones, swept);
}

/// The prisms that fold when a solid turns in one step.
std::uint64_t foldsOfTurn(const TriangleMesh& solid, double degrees) {
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(degrees * M_PI / 180, Eigen::Vector3d(1, -2, 0.5).normalized())
          .toRotationMatrix();
  return sweptTo(solid, [&](const Point3& p) { return turn * p; })->foldedPrisms;
}

/// The prisms of a step with a cell that faces away from the mean direction of its triangle: of
/// area vectors, which are quadratic in time, by Simpson's rule.
std::uint64_t foldsIn(const TriangleMesh& solid, const model::Slab& step) {
  const auto areaAt = [&](const model::Triangle& triangle, double s) -> Eigen::Vector3d {
    const auto corner = [&](int k) -> Point3 {
      const auto vertex = triangle[k];
      return ((1 - s) * step.lowerLayer()[vertex] + s * step.upperLayer()[vertex]).head<3>();
    };
    return (corner(1) - corner(0)).cross(corner(2) - corner(0));
  };
  const auto& cells = step.connectivity->cells;
  const std::size_t perPrism = cells.size() / solid.triangles.size();
  std::uint64_t folds = 0;
  for (std::size_t i = 0; i < solid.triangles.size(); ++i) {
    const model::Triangle& triangle = solid.triangles[i];
    const Eigen::Vector3d mean =
        (areaAt(triangle, 0) + 4 * areaAt(triangle, 0.5) + areaAt(triangle, 1)) / 6;
    bool folded = false;
    for (std::size_t k = i * perPrism; k < (i + 1) * perPrism; ++k) {
      Eigen::Matrix4d sides;
      sides.col(0) << mean, 0;
      for (int side = 1; side < 4; ++side) {
        sides.col(side) = step.vertices[cells[k][side]] - step.vertices[cells[k][0]];
      }
      folded = folded || sides.determinant() <= 0;
    }
    folds += folded ? 1 : 0;
  }
  return folds;
}

TEST(Folds, AreCellsThatFaceAwayFromTheMeanDirectionOfTheirTriangle) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> number(-1, 1);
  const TriangleMesh solid = fixtures::icosphere(2, 1);
  for (const double amount : {0.6, 1.0, 1.5, 2.0}) {
    std::vector<StoredKeys::Key> keys = {{0, solid.vertices}, {1, solid.vertices}};
    for (Point3& p : keys[1].positions) {
      p += amount * Point3(number(random), number(random), number(random));
    }
    model::Mesh swept;
    const auto report = sweep(solid, StoredKeys(keys), kCones, swept);
    ASSERT_TRUE(report) << report.error().text();
    const std::uint64_t folds = foldsIn(solid, swept.slabs()[1]);
    EXPECT_EQ(report->foldedPrisms, folds) << amount;
    EXPECT_GT(folds, 0U) << amount;
    EXPECT_LT(folds, solid.triangles.size()) << amount;
  }
}

TEST(Folds, SmallTurnsAndShrinkingHaveNone) {
  for (const fixtures::NamedSolid& solid : fixtures::allSolids({})) {
    SCOPED_TRACE(solid.name);
    EXPECT_EQ(foldsOfTurn(solid.mesh, 0), 0U);
    EXPECT_EQ(foldsOfTurn(solid.mesh, 5), 0U);
    EXPECT_EQ(sweptTo(solid.mesh, [](const Point3& p) { return 0.1 * p; })->foldedPrisms, 0U);
  }
}

TEST(Folds, LargeTurnsFoldSliversOnly) {
  for (const double degrees : {30.0, 60.0, 85.0}) {
    EXPECT_EQ(foldsOfTurn(fixtures::icosphere(2, 1), degrees), 0U);
    EXPECT_EQ(foldsOfTurn(fixtures::torus(2, 1, 12, 8), degrees), 0U);
    EXPECT_GT(foldsOfTurn(fixtures::boltWithThread(), degrees), 0U);
  }
}

TEST(Folds, SliversThatRestOrMoveHaveNone) {
  // An octahedron with a corner on an edge of its base, or off it by so much, at places far from
  // the origin; positions are keys, so that no pose tells that the solid only moves.
  std::mt19937 random(4);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int trial = 0; trial < 300; ++trial) {
    TriangleMesh solid = fixtures::paperCube(2);
    const double width = std::pow(10, -17 + 0.05 * trial);
    // The middle of a face goes to one of its edges.
    for (Point3& p : solid.vertices) {
      if (p.cwiseAbs().sum() == 1 && p.x() == 1) p.y() = 1 - width;
    }
    const Eigen::Matrix3d turn =
        Eigen::Quaterniond(number(random), number(random), number(random), 1.1)
            .normalized()
            .toRotationMatrix();
    const Point3 place = 10 * Point3(number(random), number(random), number(random));
    for (Point3& p : solid.vertices) p = turn * p + place;
    const Point3 way = 100 * Point3(number(random), number(random), number(random));
    EXPECT_EQ(sweptTo(solid, [](const Point3& p) { return p; })->foldedPrisms, 0U) << width;
    EXPECT_EQ(sweptTo(solid, [&](const Point3& p) -> Point3 { return p + way; })->foldedPrisms, 0U)
        << width;
  }
}

TEST(Folds, OfPosesAreThoseOfTheWholeSolid) {
  using Turn = Eigen::AngleAxisd;
  const auto poseOf = [](const Eigen::Matrix3d& linear) {
    model::Affine3x4 pose = model::Affine3x4::Zero();
    pose.leftCols<3>() = linear;
    pose.col(3) = Point3(5, 6, 7);
    return pose;
  };
  const model::Affine3x4 rest = poseOf(Eigen::Matrix3d::Identity());
  const Point3 axis = Point3(1, -2, 0.5).normalized();
  for (const double degrees : {0.0, 5.0, 60.0, 119.0}) {
    const Eigen::Matrix3d turn = Turn(degrees * M_PI / 180, axis).toRotationMatrix();
    EXPECT_TRUE(foldsNowhere(rest, poseOf(turn))) << degrees;
    EXPECT_TRUE(foldsNowhere(rest, poseOf(1e-3 * turn))) << degrees;
    EXPECT_TRUE(foldsNowhere(poseOf(-turn), poseOf(-Eigen::Matrix3d::Identity()))) << degrees;
  }
  EXPECT_FALSE(foldsNowhere(rest, poseOf(Turn(M_PI, axis).toRotationMatrix())));
  EXPECT_FALSE(foldsNowhere(rest, poseOf(-0.5 * Eigen::Matrix3d::Identity())));
  EXPECT_FALSE(foldsNowhere(rest, poseOf(Eigen::Matrix3d::Zero())));
}

TEST(Folds, OfSeveralStepsAreCountedTogether) {
  const TriangleMesh solid = fixtures::icosphere(2, 1);
  std::vector<StoredKeys::Key> keys;
  for (int k = 0; k < 4; ++k) {
    keys.push_back({double(k), solid.vertices});
    if (k % 2 == 1) {
      for (Point3& p : keys.back().positions) p = -0.5 * p;
    }
  }
  model::Mesh swept;
  const auto report = sweep(solid, StoredKeys(keys), kCones, swept);
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_EQ(report->foldedSteps, 3U);
  EXPECT_EQ(report->foldedPrisms, 3 * solid.triangles.size());
}

TEST(Folds, SolidTurnedInsideOutFoldsEverywhere) {
  const TriangleMesh solid = fixtures::icosphere(2, 1);
  const auto report = sweptTo(solid, [](const Point3& p) { return -0.5 * p; });
  EXPECT_EQ(report->foldedPrisms, solid.triangles.size());
  EXPECT_EQ(report->foldedSteps, 1U);
  ASSERT_EQ(report->notices.size(), 2U);
  EXPECT_NE(report->notices[1].find("80 prisms in 1 of 1 steps"), std::string::npos)
      << report->notices[1];
}

TEST(Folds, ArePlacedWhereOneVertexPassesThroughItsTriangle) {
  // One corner of a subdivided cube's face goes across its neighbours in the face's plane.
  const TriangleMesh solid = fixtures::paperCube(2);
  const std::uint32_t moved = solid.triangles[0][0];
  const Point3 start = solid.vertices[moved];
  const Point3 end = 3 * solid.vertices[solid.triangles[0][1]] - 2 * start;
  std::vector<StoredKeys::Key> keys{{0, solid.vertices}, {1, solid.vertices}, {3, solid.vertices}};
  keys[2].positions[moved] = end;
  model::Mesh swept;
  const auto report = sweep(solid, StoredKeys(keys), kCones, swept);
  ASSERT_TRUE(report);
  ASSERT_EQ(report->folds.size(), 1U);
  EXPECT_EQ(report->folds[0].time.begin, 1);
  EXPECT_EQ(report->folds[0].time.end, 3);
  const auto& corners = solid.triangles[report->folds[0].triangle];
  EXPECT_NE(std::find(corners.begin(), corners.end(), moved), corners.end());
  EXPECT_LT((report->folds[0].place - start).norm(), 4);
}

TEST(Deformation, RefusesWhatIsNoDeformation) {
  const TriangleMesh solid = fixtures::cube(2);
  const auto errorOf = [&](std::vector<StoredKeys::Key> keys) {
    model::Mesh swept;
    const auto report = sweep(solid, StoredKeys(std::move(keys)), kCones, swept);
    return report ? "none" : report.error().message;
  };
  const auto flat = [&] {
    auto positions = solid.vertices;
    for (Point3& p : positions) p.z() = 0;
    return positions;
  }();
  auto far = solid.vertices;
  far[3].y() = std::nan("");
  EXPECT_EQ(errorOf({{0, solid.vertices}}), "there is 1 key; at least two are needed");
  EXPECT_NE(errorOf({{0, solid.vertices}, {0, solid.vertices}}).find("not after the key before"),
            std::string::npos);
  EXPECT_EQ(errorOf({{0, flat}, {1, solid.vertices}}), "the mesh encloses no volume");
  EXPECT_NE(errorOf({{0, solid.vertices}, {1, far}}).find("vertex 3 is at"), std::string::npos);
  for (const double distance : {1e14, 1e16, 1e30}) {
    auto moved = solid.vertices;
    for (Point3& p : moved) p.x() += distance;
    EXPECT_NE(errorOf({{0, solid.vertices}, {1, moved}}).find("doubles"), std::string::npos);
    EXPECT_NE(errorOf({{0, moved}, {1, moved}}).find("doubles"), std::string::npos);
  }
  // What is wrong at a key names the key and its time, not the mesh.
  const auto placeOf = [&](std::vector<StoredKeys::Key> keys) {
    model::Mesh swept;
    return sweep(solid, StoredKeys(std::move(keys)), kCones, swept).error().where.text();
  };
  EXPECT_EQ(placeOf({{0.5, flat}, {1, solid.vertices}}), "key 0, at time 0.5");
  EXPECT_EQ(placeOf({{0, solid.vertices}, {1.25, far}}), "key 1, at time 1.25");
  // The solid may shrink to a point.
  EXPECT_EQ(errorOf({{0, solid.vertices}, {1, std::vector<Point3>(8, Point3(1e6, 0, 0))}}), "none");
}

}  // namespace
}  // namespace t4d::mesh4d
