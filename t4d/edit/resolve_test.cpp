#include "t4d/edit/resolve.h"

#include <cmath>

#include <gtest/gtest.h>

#include "t4d/convert/slice.h"
#include "t4d/edit/surface_crossings.h"
#include "t4d/fixtures/solids.h"
#include "t4d/measure/mesh_check.h"
#include "t4d/mesh4d/sweep.h"

namespace t4d::edit {
namespace {

using model::Point3;

model::TriangleMesh placed(model::TriangleMesh mesh, const Point3& scale, const Point3& at) {
  for (Point3& vertex : mesh.vertices) vertex = vertex.cwiseProduct(scale) + at;
  return mesh;
}

/// A solid that goes from where it is by `along` and turns by `degrees` about the z axis through the
/// origin, in a time of 1.
model::Mesh moved(const model::TriangleMesh& mesh, const Point3& along, double degrees,
                  std::uint64_t steps) {
  model::ScrewRun run;
  run.duration = 1;
  run.screw.angleDegrees = degrees;
  run.screw.translation = along;
  model::Mesh swept;
  const auto report = mesh4d::sweep(mesh, *model::chainScrews(0, {&run, 1}),
                                    {mesh4d::StepsPerSegment{steps}}, swept);
  EXPECT_TRUE(report) << report.error().text();
  return swept;
}

model::Mesh copyOf(const model::Source& source) {
  model::Mesh mesh;
  EXPECT_TRUE(model::pump(source, mesh));
  return mesh;
}

/// What must hold of every resolved body.
void expectSound(const model::Mesh& obstacle, const model::Mesh& before, const model::Mesh& after) {
  const model::Body a{"obstacle", &obstacle};
  const auto again = resolve({&a, 1}, {"body", &after}, {});
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_FALSE(again->report.changed);
  const auto checked = measure::checkMesh(after);
  ASSERT_TRUE(checked) << checked.error().text();
  EXPECT_TRUE(checked->valid());
  EXPECT_TRUE(checked->closed && checked->oriented);
  for (double time = 0; time <= 1; time += 1.0 / 64) {
    const auto slice = convert::sliceAtTime(after, time);
    ASSERT_TRUE(slice) << slice.error().text();
    EXPECT_TRUE(isClosed(slice->mesh));
    if (findsCrossings()) {
      EXPECT_TRUE(findCrossings(slice->mesh, 1)->pairs.empty()) << time;
    }
  }
  EXPECT_GE(after.slabCount(), before.slabCount());
}

/// Where nothing touched, nothing has moved: slabs whose layers do not move are the same, vertices
/// and cells, and the others as many vertices as were counted.
void expectLittleMoved(const model::Mesh& before, const model::Mesh& after,
                       const ResolveReport& report) {
  ASSERT_EQ(before.slabCount() + report.addedLayers, after.slabCount());
  if (report.addedLayers > 0) return;
  std::size_t count = 0;
  for (std::size_t i = 0; i < before.slabCount(); ++i) {
    const model::Slab& one = before.slabs()[i];
    const model::Slab& other = after.slabs()[i];
    if (!(one.timeBegin < one.timeEnd)) continue;
    EXPECT_EQ(one.connectivity->cells, other.connectivity->cells);
    for (std::size_t k = 0; k < one.lowerLayer().size(); ++k) {
      count += one.lowerLayer()[k] != other.lowerLayer()[k] ? 1 : 0;
    }
    const ResolvedLayer& lower = report.layers[i - 1];
    const ResolvedLayer& upper = report.layers[i];
    if (lower.displacement == 0 && upper.displacement == 0) {
      EXPECT_EQ(one.vertices, other.vertices);
    }
  }
  EXPECT_EQ(count, report.movedVertices);
}

struct BallAndPlate {
  model::Mesh plate = moved(placed(fixtures::paperCube(1), {4, 8, 0.5}, {2.6, 0, 0}), {0, 0, 0}, 0, 1);
  model::Mesh ball = moved(placed(fixtures::icosphere(1, 3), {1, 1, 1}, {0, 0, -4}), {0, 0, 8}, 0, 32);
};

TEST(Resolve, BallThatPassesAPlatesEdgeHasADentThatHeals) {
  const BallAndPlate given;
  const model::Body plate{"plate", &given.plate};
  const auto resolved = resolve({&plate, 1}, {"ball", &given.ball}, {.smoothTime = 0.1});
  ASSERT_TRUE(resolved) << resolved.error().text();
  EXPECT_TRUE(resolved->report.changed);
  // The edge is at x = 0.6: the ball is 0.4 too wide.
  EXPECT_GT(resolved->report.maxDisplacement, 0.39);
  EXPECT_LT(resolved->report.maxDisplacement, 0.6);
  const model::Mesh after = copyOf(*resolved->source);
  expectSound(given.plate, given.ball, after);
  EXPECT_LT(resolved->report.volumeChangeMax, 0);
  expectLittleMoved(given.ball, after, resolved->report);
  EXPECT_EQ(resolved->report.layers.front().displacement, 0);
  EXPECT_EQ(resolved->report.layers.back().displacement, 0);
}

}  // namespace
}  // namespace t4d::edit
