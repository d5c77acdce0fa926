#include "measure/offset_surface.h"

#include <random>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "measure/triangle_tree.h"
#include "measure/winding_number.h"
#include "model/surface_check.h"

namespace t4d::measure {
namespace {

using model::Point3;
using model::TriangleMesh;

OffsetSurface offsetOf(const TriangleMesh& mesh, double spacing, double reach) {
  model::Bounds3 bounds = model::boundsOf(mesh);
  bounds.min.array() -= offsetMargin(reach, spacing);
  bounds.max.array() += offsetMargin(reach, spacing);
  auto lattice = SpaceLattice::about(bounds, spacing);
  EXPECT_TRUE(lattice) << (lattice ? "" : lattice.error().text());
  const VisitLattice visits(mesh, std::move(*lattice), {}, /*withCrossings=*/false);
  return offsetSurface(mesh, visits, reach).value();
}

TriangleMesh plate() {
  TriangleMesh mesh = fixtures::cube(2);
  for (Point3& v : mesh.vertices) v = {v.x() + 0.3 * v.y(), 2 * v.y(), 1e-4 * v.z() + 0.7 * v.x()};
  return mesh;
}

TEST(OffsetSurface, ContainsWhatIsInReachAndNothingFartherThanItSays) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> part(0, 1);
  std::normal_distribution<double> normal;
  for (const TriangleMesh& mesh :
       {fixtures::cube(2), fixtures::pebble(1.3, 60), fixtures::torus(1.1, 0.4, 9, 7),
        fixtures::hollowCube(2, 1.2), fixtures::twoBoxes(1, 0.3), plate()}) {
    const TriangleTree tree(mesh);
    const WindingNumber solid(mesh);
    for (const double spacing : {0.13, 0.31, 1.7}) {
      for (const double reach : {0.0, 0.04, 0.6}) {
        SCOPED_TRACE(::testing::Message() << spacing << " " << reach);
        const OffsetSurface offset = offsetOf(mesh, spacing, reach);
        ASSERT_TRUE(model::checkClosedSurface(offset.mesh));
        const WindingNumber winding(offset.mesh);
        for (int k = 0; k < 150; ++k) {
          const auto& [a, b, c] = mesh.triangles[random() % mesh.triangles.size()];
          const double u = part(random);
          const double v = (1 - u) * part(random);
          const Point3 direction =
              Point3(normal(random), normal(random), normal(random)).normalized();
          const Point3 point = (1 - u - v) * mesh.vertices[a] + u * mesh.vertices[b] +
                               v * mesh.vertices[c] + (k % 2 == 0 ? reach : 0) * direction;
          EXPECT_GT(winding.exactAt(point), 0.5);
        }
        for (const Point3& vertex : offset.mesh.vertices) {
          if (solid.at(vertex) > 0.75) continue;
          EXPECT_LE(tree.nearest(vertex).distance, offset.farthest);
        }
      }
    }
  }
}

TEST(OffsetSurface, IsTheSameAtAnyScale) {
  const TriangleMesh mesh = fixtures::pebble(1.3, 60);
  const OffsetSurface one = offsetOf(mesh, 0.25, 0.1);
  for (const int exponent : {-230, -100, 40, 200}) {
    TriangleMesh scaled = mesh;
    for (Point3& vertex : scaled.vertices) vertex *= std::ldexp(1, exponent);
    const OffsetSurface made =
        offsetOf(scaled, std::ldexp(0.25, exponent), std::ldexp(0.1, exponent));
    ASSERT_EQ(made.mesh.triangles, one.mesh.triangles);
    for (std::size_t i = 0; i < one.mesh.vertices.size(); ++i) {
      EXPECT_EQ(made.mesh.vertices[i], one.mesh.vertices[i] * std::ldexp(1, exponent));
    }
  }
}

}  // namespace
}  // namespace t4d::measure
