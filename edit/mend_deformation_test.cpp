#include "edit/mend_deformation.h"

#include <cmath>

#include <gtest/gtest.h>

#include "edit/divide_solids.h"
#include "fixtures/solids.h"
#include "model/surface_check.h"

namespace t4d::edit {
namespace {

using model::Point3;
using model::StoredKeys;
using model::TriangleMesh;

Runs runOf(std::vector<StoredKeys::Key> keys) {
  Runs runs;
  runs.push_back(std::make_unique<StoredKeys>(std::move(keys)));
  return runs;
}

/// A solid that leans over and grows.
Runs leaning(const TriangleMesh& mesh) {
  std::vector<StoredKeys::Key> keys;
  for (int k = 0; k < 4; ++k) {
    StoredKeys::Key key{0.5 * k, {}};
    for (const Point3& p : mesh.vertices) {
      key.positions.emplace_back((1 + k) * p.x() + k * p.z() * p.z(), p.y(), p.z());
    }
    keys.push_back(std::move(key));
  }
  return runOf(std::move(keys));
}

std::string errorOf(TriangleMesh mesh, Runs keys, const MendSurfaceOptions& options = {}) {
  const auto report = mendDeformation(mesh, keys, options);
  return report ? "none" : report.error().message;
}

TEST(MendDeformation, KeepsEveryVertexInItsPlaceAtEveryKey) {
  const TriangleMesh whole = fixtures::icosphere(1, 3);
  TriangleMesh mesh = whole;
  // A hole around one vertex, which goes; some triangles turned over, and one there twice.
  constexpr std::uint32_t kGone = 50;
  std::erase_if(mesh.triangles, [&](const auto& t) { return std::ranges::count(t, kGone) > 0; });
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 9)
    std::swap(mesh.triangles[i][0], mesh.triangles[i][1]);
  mesh.triangles.push_back(mesh.triangles[7]);
  auto keys = leaning(mesh);
  const auto report = mendDeformation(mesh, keys);
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_TRUE(model::checkClosedSurface(mesh));
  EXPECT_EQ(mesh.vertices.size(), whole.vertices.size() - 1);
  EXPECT_EQ(mesh.triangles.size(), whole.triangles.size() - 2);
  const auto given = leaning(whole);
  std::vector<Point3> places(mesh.vertices.size());
  ASSERT_EQ(keys.front()->count(), 4U);
  for (std::uint64_t key = 0; key < 4; ++key) {
    EXPECT_EQ(keys.front()->time(key), given.front()->time(key));
    ASSERT_TRUE(keys.front()->positions(key, places));
    std::vector<Point3> expected(whole.vertices.size());
    ASSERT_TRUE(given.front()->positions(key, expected));
    expected.erase(expected.begin() + kGone);
    EXPECT_EQ(places, expected);
  }
}

TEST(MendDeformation, MergesVerticesThatStayTogether) {
  TriangleMesh mesh = fixtures::cube(2);
  mesh.vertices.emplace_back(mesh.vertices[mesh.triangles[0][0]] + Point3(1e-7, 0, 0));
  mesh.triangles[0][0] = 8;
  auto keys = leaning(mesh);
  auto merged = mesh;
  const auto report = mendDeformation(merged, keys, {.weld = 1e-5});
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_EQ(merged.vertices.size(), 8U);
  std::vector<Point3> places(8);
  for (std::uint64_t key = 0; key < 4; ++key) EXPECT_TRUE(keys.front()->positions(key, places));
  // One that leaves the other is an error of its key.
  std::vector<StoredKeys::Key> apart{{0, mesh.vertices}, {1, mesh.vertices}};
  apart[1].positions[8].y() += 0.5;
  keys = runOf(apart);
  merged = mesh;
  ASSERT_TRUE(mendDeformation(merged, keys, {.weld = 1e-5}));
  EXPECT_TRUE(keys.front()->positions(0, places));
  const auto read = keys.front()->positions(1, places);
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message.find("0.5 apart at time 1"), std::string::npos);
}

TEST(MendDeformation, EachOfSeveralMergedVerticesMustStay) {
  TriangleMesh mesh = fixtures::cube(2);
  const std::uint32_t kept = mesh.triangles[0][0];
  for (model::Triangle& triangle : mesh.triangles) {
    const auto at = std::ranges::find(triangle, kept);
    if (at == triangle.end() || &triangle == &mesh.triangles[0]) continue;
    *at = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(mesh.vertices[kept]);
  }
  ASSERT_GT(mesh.vertices.size(), 10U);
  for (std::size_t leaves = 8; leaves < mesh.vertices.size(); ++leaves) {
    std::vector<StoredKeys::Key> places{{0, mesh.vertices}, {1, mesh.vertices}};
    places[1].positions[leaves].y() += 0.5;
    Runs keys = runOf(places);
    TriangleMesh merged = mesh;
    ASSERT_TRUE(mendDeformation(merged, keys, {.weld = 1e-5}));
    std::vector<Point3> into(8);
    EXPECT_TRUE(keys.front()->positions(0, into));
    EXPECT_FALSE(keys.front()->positions(1, into)) << leaves;
  }
}

/// The positions at a key, as a mesh with these triangles.
TriangleMesh placedAt(const TriangleMesh& mesh, const Runs& runs, std::uint64_t key) {
  TriangleMesh placed{std::vector<Point3>(mesh.vertices.size()), mesh.triangles, {}};
  EXPECT_TRUE(runs.front()->positions(key, placed.vertices));
  return placed;
}

TEST(MendDeformation, GivesSheetsTheirThicknessAtEachKey) {
  // A flat sheet of 4 x 2 that is turned and stretched.
  TriangleMesh sheet;
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 5; ++x) sheet.vertices.emplace_back(x, y, 0);
  }
  for (std::uint32_t i = 0; i < 10; ++i) {
    if (i % 5 == 4) continue;
    sheet.triangles.push_back({i, i + 1, i + 6});
    sheet.triangles.push_back({i, i + 6, i + 5});
  }
  std::vector<StoredKeys::Key> keys;
  for (int k = 0; k < 3; ++k) {
    StoredKeys::Key key{1.0 * k, {}};
    const double angle = 0.6 * k;
    for (const Point3& p : sheet.vertices) {
      key.positions.emplace_back((1 + k) * p.x(), std::cos(angle) * p.y(), std::sin(angle) * p.y());
    }
    keys.push_back(std::move(key));
  }
  EXPECT_NE(errorOf(sheet, runOf(keys)).find("1 sheet encloses nothing"), std::string::npos);
  TriangleMesh mesh = sheet;
  Runs runs = runOf(keys);
  constexpr double kThickness = 0.01;
  const auto report = mendDeformation(mesh, runs, {.thicken = kThickness});
  ASSERT_TRUE(report) << report.error().text();
  ASSERT_TRUE(model::checkClosedSurface(mesh));
  for (std::uint64_t key = 0; key < 3; ++key) {
    const double area = (1 + static_cast<double>(key)) * 8;
    EXPECT_NEAR(signedVolume(placedAt(mesh, runs, key)), area * kThickness, 1e-14 * area) << key;
  }
}

TEST(MendDeformation, PartsThatTouchGetVerticesOfTheirOwn) {
  // Two cubes that share an edge, which stay together.
  TriangleMesh both = fixtures::cube(2);
  TriangleMesh other = fixtures::cube(2);
  for (Point3& p : other.vertices) p += Point3(2, 2, 0);
  for (const auto& [a, b, c] : other.triangles) both.triangles.push_back({a + 8, b + 8, c + 8});
  both.vertices.insert(both.vertices.end(), other.vertices.begin(), other.vertices.end());
  Runs runs = leaning(both);
  TriangleMesh mesh = both;
  const auto report = mendDeformation(mesh, runs, {}, Crossings::Accepted);
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_TRUE(model::checkClosedSurface(mesh));
  EXPECT_EQ(mesh.vertices.size(), 16U + 2);  // and one in the middle of the edge for each
  for (std::uint64_t key = 0; key < 4; ++key) {
    const double expected = signedVolume(placedAt(both, leaning(both), key));
    EXPECT_NEAR(signedVolume(placedAt(mesh, runs, key)), expected, 1e-14 * expected) << key;
  }
}

TEST(DivideSolids, CavitiesBelongToWhatIsAroundThem) {
  // A ball in the cavity of a shell, and a cube beside.
  TriangleMesh all = fixtures::icosphere(3, 1);
  const auto add = [&](const TriangleMesh& mesh, bool inward) {
    const auto first = static_cast<std::uint32_t>(all.vertices.size());
    all.vertices.insert(all.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
    for (const auto& [a, b, c] : mesh.triangles) {
      all.triangles.push_back({first + a, first + (inward ? c : b), first + (inward ? b : c)});
    }
  };
  add(fixtures::icosphere(2, 1), true);
  add(fixtures::icosphere(1, 1), false);
  TriangleMesh cube = fixtures::cube(1);
  for (Point3& p : cube.vertices) p.x() += 8;
  add(cube, false);
  const auto solids = divideSolids(all, leaning(all));
  ASSERT_TRUE(solids);
  ASSERT_EQ(solids->size(), 3U);
  const double ball =
      signedVolume(placedAt(fixtures::icosphere(1, 1), leaning(fixtures::icosphere(1, 1)), 0));
  const double expected[] = {19 * ball, ball, 1};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& [mesh, runs] = (*solids)[i];
    EXPECT_TRUE(model::checkClosedSurface(mesh));
    EXPECT_NEAR(signedVolume(placedAt(mesh, runs, 0)), expected[i], 1e-12) << i;
  }
}

TEST(MendDeformation, RefusesWhatWouldMoveVertices) {
  const TriangleMesh cube = fixtures::cube(2);
  EXPECT_EQ(errorOf(cube, leaning(cube)), "none");
  TriangleMesh crossing = cube;
  for (const Point3& p : cube.vertices) crossing.vertices.emplace_back(p + Point3(0.7, 0.8, 0.9));
  for (const auto& [a, b, c] : cube.triangles) crossing.triangles.push_back({a + 8, b + 8, c + 8});
  EXPECT_NE(errorOf(crossing, leaning(crossing)).find("would move vertices"), std::string::npos);
  Runs keys = leaning(crossing);
  TriangleMesh kept = crossing;
  ASSERT_TRUE(mendDeformation(kept, keys, {}, Crossings::Accepted));
  EXPECT_EQ(kept.triangles, crossing.triangles);
  TriangleMesh open = cube;
  open.triangles.resize(10);
  EXPECT_EQ(errorOf(open, leaning(open)), "none");
  EXPECT_NE(errorOf(open, leaning(open), {.maxHole = 1}).find("wider than 1"), std::string::npos);
}

}  // namespace
}  // namespace t4d::edit
