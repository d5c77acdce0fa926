#include "formats/triangle/rounding_loss.h"

#include <gtest/gtest.h>

namespace t4d::formats {
namespace {

/// A square of side 1 at (x, 0, 0), divided into columns of this number of strips of triangles.
model::TriangleMesh squareAt(double x, std::uint32_t strips) {
  model::TriangleMesh mesh;
  for (std::uint32_t i = 0; i <= strips; ++i) {
    const double at = x + static_cast<double>(i) / strips;
    mesh.vertices.emplace_back(at, 0, 0);
    mesh.vertices.emplace_back(at, 1, 0);
  }
  for (std::uint32_t i = 0; i < strips; ++i) {
    mesh.triangles.push_back({2 * i, 2 * i + 2, 2 * i + 1});
    mesh.triangles.push_back({2 * i + 1, 2 * i + 2, 2 * i + 3});
  }
  return mesh;
}

std::optional<std::string> lossOf(const model::TriangleMesh& mesh) {
  std::vector<Eigen::Vector3f> rounded;
  for (const model::Point3& vertex : mesh.vertices) rounded.push_back(vertex.cast<float>());
  RoundingLoss loss;
  loss.add(mesh, rounded);
  return loss.line();
}

TEST(RoundingLoss, IsNoneWhereFloat32IsFineEnough) {
  EXPECT_FALSE(lossOf(squareAt(0, 100)));
  EXPECT_FALSE(lossOf(squareAt(1e5, 100)));  // in steps of 1/128
  EXPECT_FALSE(RoundingLoss().line());
}

TEST(RoundingLoss, CountsTrianglesThatBecomeFlat) {
  // One of the 16 strips keeps its width in steps of 1.
  const auto line = lossOf(squareAt(1 << 23, 16));
  ASSERT_TRUE(line);
  EXPECT_NE(line->find("30 of 32 triangles become flat or turn over in float32, which has steps of "
                       "1 at coordinates of 8.39e+06"),
            std::string::npos)
      << *line;
}

TEST(RoundingLoss, FindsASmallPartThatIsLost) {
  model::TriangleMesh mesh = squareAt(0, 1);
  for (model::Point3& vertex : mesh.vertices) vertex *= 2e6;
  const model::TriangleMesh small = squareAt(0, 1);
  for (const model::Point3& vertex : small.vertices) {
    mesh.vertices.push_back(0.05 * vertex + model::Point3(3e6, 0, 0));
  }
  for (const auto& [a, b, c] : small.triangles) mesh.triangles.push_back({a + 4, b + 4, c + 4});
  EXPECT_TRUE(lossOf(mesh));
}

TEST(RoundingLoss, IgnoresSlivers) {
  model::TriangleMesh mesh = squareAt(1, 1);
  // A triangle of no breadth in float32, and next to no area.
  mesh.vertices.emplace_back(1, 0.5, 0);
  mesh.vertices.emplace_back(1 + 1e-9, 0.5, 0);
  mesh.triangles.push_back({0, 5, 4});
  EXPECT_FALSE(lossOf(mesh));
}

}  // namespace
}  // namespace t4d::formats
