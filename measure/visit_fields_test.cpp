#include "measure/visit_fields.h"

#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "fixtures/solids.h"
#include "t4d/envelope.h"
#include "t4d/mesh.h"
#include "t4d/sweep.h"

namespace t4d::measure {
namespace {

using model::Point3;

model::Mesh sweptByScrew(const model::TriangleMesh& solid, const model::Screw& screw,
                         mesh4d::CapMethod caps) {
  const model::ScrewRun run{2, screw, 1};
  const auto motion = model::chainScrews(1, {&run, 1});
  EXPECT_TRUE(motion);
  model::Mesh mesh;
  EXPECT_TRUE(mesh4d::sweep(solid, *motion, {.caps = caps}, mesh));
  return mesh;
}

VisitFields fieldsOf(const model::Mesh& mesh, SpaceLattice lattice) {
  VisitFieldBuilder builder(std::move(lattice));
  EXPECT_TRUE(model::pump(mesh, builder));
  return builder.finish();
}

TEST(VisitFields, OfACubeThatMovesAlongAnAxisAreInClosedForm) {
  // The solid moves from x = -1 .. 1 at time 1 to x = 5 .. 7 at time 3, at speed 3.
  const model::Mesh mesh =
      sweptByScrew(fixtures::cube(2), {.translation = {6, 0, 0}}, mesh4d::CapMethod::TetGen);
  auto lattice = SpaceLattice::about({Point3(-1, -1, -1), Point3(7, 1, 1)}, 0.3);
  ASSERT_TRUE(lattice);
  const VisitFields fields = fieldsOf(mesh, *lattice);
  for (std::uint32_t x = 0; x < lattice->at[0].size(); ++x) {
    for (std::uint32_t y = 0; y < lattice->at[1].size(); ++y) {
      for (std::uint32_t z = 0; z < lattice->at[2].size(); ++z) {
        const std::size_t row = fields.rowOf({x, y, z});
        const double at = lattice->at[0][x];
        const bool inside =
            std::abs(lattice->at[1][y]) < 1 && std::abs(lattice->at[2][z]) < 1 && at > -1 && at < 7;
        ASSERT_EQ(fields.visits[row], inside ? 1 : 0);
        if (!inside) continue;
        const double first = std::max(1.0, 1 + (at - 1) / 3);
        const double last = std::min(3.0, 1 + (at + 1) / 3);
        EXPECT_NEAR(fields.first[row], first, 1e-12);
        EXPECT_NEAR(fields.last[row], last, 1e-12);
        EXPECT_NEAR(fields.dwell[row], last - first, 1e-12);
      }
    }
  }
}

TEST(VisitFields, AgreeWithTheSilhouetteAndTheHypervolume) {
  model::TriangleMesh pebble = fixtures::pebble(1, 100);
  for (Point3& vertex : pebble.vertices) vertex.x() += 2;
  const model::Screw screw{.axisDirection = Point3(1, 2, 3).normalized(),
                           .angleDegrees = 500,
                           .translation = {0.3, 0.2, 0.1}};
  for (const mesh4d::CapMethod caps : {mesh4d::CapMethod::TetGen, mesh4d::CapMethod::Cone}) {
    const model::Mesh mesh = sweptByScrew(pebble, screw, caps);
    const auto silhouette = silhouetteOf(mesh);
    ASSERT_TRUE(silhouette);
    auto lattice = SpaceLattice::about(model::boundsOf(silhouette->surface), 0.11);
    ASSERT_TRUE(lattice);
    const VisitLattice visits(silhouette->surface, *lattice);
    const VisitFields fields = fieldsOf(mesh, *lattice);
    int most = 0;
    for (std::uint32_t x = 0; x < lattice->at[0].size(); ++x) {
      for (std::uint32_t y = 0; y < lattice->at[1].size(); ++y) {
        for (std::uint32_t z = 0; z < lattice->at[2].size(); ++z) {
          const std::size_t row = fields.rowOf({x, y, z});
          ASSERT_EQ(fields.visits[row], visits.winding({x, y, z}));
          most = std::max(most, fields.visits[row]);
          ASSERT_GE(fields.dwell[row], -1e-12);
          ASSERT_LE(fields.dwell[row], fields.last[row] - fields.first[row] + 1e-12);
        }
      }
    }
    EXPECT_GE(most, 2);
    const double volume = 0.11 * 0.11 * 0.11;
    const double dwell = std::accumulate(fields.dwell.begin(), fields.dwell.end(), 0.0);
    EXPECT_NEAR(dwell * volume / silhouette->hypervolume, 1, 2e-3);
    const double times = std::accumulate(fields.visits.begin(), fields.visits.end(), 0.0);
    EXPECT_NEAR(times * volume / silhouette->visitsVolume, 1, 2e-3);
  }
}

/// Cells of a cone over a solid with a hole overlap, and cover what the solid does not.
TEST(VisitFields, DoNotDependOnHowTheEndsAreClosed) {
  const model::TriangleMesh ring = fixtures::torus(2, 0.7, 12, 6);
  const model::Screw screw{.axisDirection = Point3(1, 2, 3).normalized(),
                           .angleDegrees = 40,
                           .translation = {0.3, 0.2, 0.1}};
  const model::Mesh filled = sweptByScrew(ring, screw, mesh4d::CapMethod::TetGen);
  const auto lattice = SpaceLattice::about(model::boundsOf(silhouetteOf(filled)->surface), 0.21);
  ASSERT_TRUE(lattice);
  const VisitFields expected = fieldsOf(filled, *lattice);
  const VisitFields found = fieldsOf(sweptByScrew(ring, screw, mesh4d::CapMethod::Cone), *lattice);
  EXPECT_EQ(found.visits, expected.visits);
  for (std::size_t row = 0; row < found.visits.size(); ++row) {
    EXPECT_NEAR(found.dwell[row], expected.dwell[row], 1e-12);
    EXPECT_NEAR(found.first[row], expected.first[row], 1e-12);
    EXPECT_NEAR(found.last[row], expected.last[row], 1e-12);
  }
}

}  // namespace
}  // namespace t4d::measure
