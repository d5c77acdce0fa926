#include "t4d/edit/mend_deformation.h"

#include <gtest/gtest.h>

#include "t4d/fixtures/solids.h"
#include "t4d/model/surface_check.h"

namespace t4d::edit {
namespace {

using model::Point3;
using model::StoredKeys;
using model::TriangleMesh;

/// A solid that leans over and grows.
std::unique_ptr<model::VertexKeys> leaning(const TriangleMesh& mesh) {
  std::vector<StoredKeys::Key> keys;
  for (int k = 0; k < 4; ++k) {
    StoredKeys::Key key{0.5 * k, {}};
    for (const Point3& p : mesh.vertices) {
      key.positions.emplace_back((1 + k) * p.x() + k * p.z() * p.z(), p.y(), p.z());
    }
    keys.push_back(std::move(key));
  }
  return std::make_unique<StoredKeys>(std::move(keys));
}

std::string errorOf(TriangleMesh mesh, std::unique_ptr<model::VertexKeys> keys,
                    const MendSurfaceOptions& options = {}) {
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
  ASSERT_EQ(keys->count(), 4U);
  for (std::uint64_t key = 0; key < 4; ++key) {
    EXPECT_EQ(keys->time(key), given->time(key));
    ASSERT_TRUE(keys->positions(key, places));
    std::vector<Point3> expected(whole.vertices.size());
    ASSERT_TRUE(given->positions(key, expected));
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
  for (std::uint64_t key = 0; key < 4; ++key) EXPECT_TRUE(keys->positions(key, places));
  // One that leaves the other is an error of its key.
  std::vector<StoredKeys::Key> apart{{0, mesh.vertices}, {1, mesh.vertices}};
  apart[1].positions[8].y() += 0.5;
  keys = std::make_unique<StoredKeys>(apart);
  merged = mesh;
  ASSERT_TRUE(mendDeformation(merged, keys, {.weld = 1e-5}));
  EXPECT_TRUE(keys->positions(0, places));
  const auto read = keys->positions(1, places);
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
    std::unique_ptr<model::VertexKeys> keys = std::make_unique<StoredKeys>(places);
    TriangleMesh merged = mesh;
    ASSERT_TRUE(mendDeformation(merged, keys, {.weld = 1e-5}));
    std::vector<Point3> into(8);
    EXPECT_TRUE(keys->positions(0, into));
    EXPECT_FALSE(keys->positions(1, into)) << leaves;
  }
}

TEST(MendDeformation, RefusesWhatWouldMoveVertices) {
  const TriangleMesh cube = fixtures::cube(2);
  EXPECT_EQ(errorOf(cube, leaning(cube)), "none");
  TriangleMesh crossing = cube;
  for (const Point3& p : cube.vertices) crossing.vertices.emplace_back(p + Point3(0.7, 0.8, 0.9));
  for (const auto& [a, b, c] : cube.triangles) crossing.triangles.push_back({a + 8, b + 8, c + 8});
  EXPECT_NE(errorOf(crossing, leaning(crossing)).find("would move vertices"), std::string::npos);
  TriangleMesh open = cube;
  open.triangles.resize(10);
  EXPECT_EQ(errorOf(open, leaning(open)), "none");
  EXPECT_NE(errorOf(open, leaning(open), {.maxHole = 1}).find("wider than 1"), std::string::npos);
}

}  // namespace
}  // namespace t4d::edit
