#include "formats/triangle/mesh_builder.h"

#include <numeric>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "formats/triangle/polygon_triangulation.h"
#include "t4d/surface.h"

namespace t4d::formats {
namespace {

using model::Point3;

MeshBuilder builderOf(const std::vector<Point3>& points) {
  MeshBuilder builder("file",
                      [](auto place) { return placeIn({}, "place " + std::to_string(place)); });
  for (const Point3& point : points) EXPECT_TRUE(builder.addPoint(point, 0));
  return builder;
}

LoadedMesh built(const std::vector<Point3>& points,
                 const std::vector<std::vector<std::uint64_t>>& polygons) {
  auto builder = builderOf(points);
  for (const auto& polygon : polygons) EXPECT_TRUE(builder.addPolygon(polygon, 1));
  auto loaded = std::move(builder).finish();
  EXPECT_TRUE(loaded) << loaded.error().text();
  return loaded ? *loaded : LoadedMesh{};
}

LoadedMesh polygon(const std::vector<Point3>& points) {
  std::vector<std::uint64_t> corners(points.size());
  std::iota(corners.begin(), corners.end(), 0);
  return built(points, {corners});
}

/// The area on the side of the normal: less than the surface's where triangles are turned over.
double areaAlong(const model::TriangleMesh& mesh, const Point3& normal) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const auto& v = mesh.vertices;
    sum += normal.dot((v[b] - v[a]).cross(v[c] - v[a])) / 2;
  }
  return sum;
}

TEST(MeshBuilder, KeepsTheNumbersOfACleanMesh) {
  const auto loaded = built({{3, 0, 0}, {0, 2, 0}, {1, 0, 0}, {0, 0, 1}}, {{3, 1, 0}, {2, 1, 0}});
  EXPECT_EQ(loaded.mesh.triangles, (std::vector<model::Triangle>{{3, 1, 0}, {2, 1, 0}}));
  EXPECT_EQ(loaded.mesh.vertices[0], Point3(3, 0, 0));
  EXPECT_TRUE(loaded.notices.empty());
}

TEST(MeshBuilder, MergesEqualCoordinatesInOrderOfFirstAppearance) {
  const auto loaded =
      built({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-0.0, 0, -0.0}, {1, 0, 0}, {0, 0, 1}},
            {{0, 1, 2}, {4, 3, 5}});
  EXPECT_EQ(loaded.mesh.triangles, (std::vector<model::Triangle>{{0, 1, 2}, {1, 0, 3}}));
  EXPECT_FALSE(std::signbit(loaded.mesh.vertices[0].x()));
  EXPECT_TRUE(loaded.notices.empty());
}

TEST(MeshBuilder, SaysWhatItDrops) {
  const auto loaded = built({{9, 9, 9}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {8, 8, 8}},
                            {{1, 4, 2}, {1, 2, 3}, {2, 2, 2}, {1, 2, 2, 3, 4}});
  EXPECT_EQ(loaded.mesh.triangles, (std::vector<model::Triangle>{{0, 1, 2}, {0, 1, 2}}));
  EXPECT_EQ(loaded.notices, (std::vector<std::string>{"dropped 2 triangles with two equal corners",
                                                      "dropped 2 vertices that no triangle uses"}));
}

TEST(MeshBuilder, RefusesWhenNoTriangleIsLeft) {
  auto builder = builderOf({{0, 0, 0}, {1, 0, 0}, {0, 0, 0}});
  ASSERT_TRUE(builder.addPolygon(std::array<std::uint64_t, 3>{0, 1, 2}, 0));
  const auto loaded = std::move(builder).finish();
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().text(), "file: holds no triangles");
}

TEST(MeshBuilder, SplitsConcavePolygonsWithoutOverlap) {
  const std::vector<Point3> arrow{{0, 0, 5}, {4, 0, 5}, {1, 1, 5}, {0, 4, 5}};
  for (std::size_t first = 0; first < arrow.size(); ++first) {
    auto points = arrow;
    std::rotate(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(first), points.end());
    const auto mesh = polygon(points).mesh;
    EXPECT_EQ(mesh.triangles.size(), 2u);
    EXPECT_EQ(model::surfaceArea(mesh), 4);
    EXPECT_EQ(areaAlong(mesh, Point3::UnitZ()), 4);
  }
}

TEST(MeshBuilder, SplitsRandomStarsOfAnyDirectionWithoutOverlap) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> radius(0.05, 1);
  for (int round = 0; round < 200; ++round) {
    const int count = 4 + round % 60;
    const Point3 normal = Point3::Random().normalized();
    const Point3 u = normal.unitOrthogonal();
    const Point3 v = normal.cross(u);
    std::vector<Point3> points;
    double area = 0;
    for (int i = 0; i < count; ++i) {
      const double angle = 2 * M_PI * i / count;
      points.push_back(radius(random) * (std::cos(angle) * u + std::sin(angle) * v));
      if (i > 1)
        area += normal.dot(points[static_cast<std::size_t>(i) - 1].cross(points.back())) / 2;
    }
    area += normal.dot(points[0].cross(points[1]) + points.back().cross(points[0])) / 2;
    const auto mesh = polygon(points).mesh;
    EXPECT_EQ(mesh.triangles.size(), static_cast<std::size_t>(count) - 2);
    EXPECT_NEAR(model::surfaceArea(mesh), area, 1e-12) << round;
    EXPECT_NEAR(areaAlong(mesh, normal), area, 1e-12) << round;
  }
}

TEST(MeshBuilder, KeepsCornersOnStraightEdges) {
  const auto mesh =
      polygon(
          {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {2, 2, 0}, {1, 2, 0}, {0, 2, 0}, {0, 1, 0}})
          .mesh;
  EXPECT_EQ(mesh.triangles.size(), 6u);
  EXPECT_EQ(model::surfaceArea(mesh), 4);
  for (const auto& [a, b, c] : mesh.triangles) {
    const auto& v = mesh.vertices;
    EXPECT_GT((v[b] - v[a]).cross(v[c] - v[a]).norm(), 0);
  }
}

TEST(MeshBuilder, SplitsAPolygonWithABridgeToItsHole) {
  const auto mesh = built({{0, 0, 0},
                           {4, 0, 0},
                           {4, 4, 0},
                           {0, 4, 0},  //
                           {1, 1, 0},
                           {1, 3, 0},
                           {3, 3, 0},
                           {3, 1, 0}},
                          {{0, 1, 2, 3, 0, 4, 5, 6, 7, 4}})
                        .mesh;
  EXPECT_EQ(mesh.triangles.size(), 8u);
  EXPECT_EQ(model::surfaceArea(mesh), 12);
}

TEST(PolygonTriangulator, StopsWhenItHasDoneItsWork) {
  std::vector<Point3> comb{{0, -1, 0}, {100, -1, 0}};
  for (int i = 100; i >= 0; --i) comb.emplace_back(i, i % 2, 0);
  std::vector<std::uint32_t> corners(comb.size());
  std::iota(corners.begin(), corners.end(), 0);
  std::vector<model::Triangle> triangles;
  EXPECT_FALSE(PolygonTriangulator(100).add(comb, corners, triangles));
  triangles.clear();
  EXPECT_TRUE(PolygonTriangulator(10'000).add(comb, corners, triangles));
  EXPECT_EQ(triangles.size(), comb.size() - 2);
}

}  // namespace
}  // namespace t4d::formats
