#include <algorithm>
#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include "edit/displaced_source.h"
#include "edit/surface_crossings.h"
#include "fixtures/solids.h"
#include "t4d/check.h"
#include "t4d/collide.h"
#include "t4d/edit.h"
#include "t4d/slice.h"
#include "t4d/sweep.h"

namespace t4d::edit {
namespace {

using model::Point3;

model::TriangleMesh placed(model::TriangleMesh mesh, const Point3& scale, const Point3& at) {
  for (Point3& vertex : mesh.vertices) vertex = vertex.cwiseProduct(scale) + at;
  return mesh;
}

/// A solid that goes from where it is by `along` and turns by `degrees` about the z axis through
/// the origin, in a time of 1.
model::Mesh moved(const model::TriangleMesh& mesh, const Point3& along, double degrees,
                  std::uint64_t steps) {
  model::ScrewRun run;
  run.duration = 1;
  run.screw.angleDegrees = degrees;
  run.screw.translation = along;
  model::Mesh swept;
  const auto report =
      mesh4d::sweep(mesh, *model::chainScrews(0, {&run, 1}),
                    {mesh4d::StepsPerSegment{steps},
                     findsCrossings() ? mesh4d::CapMethod::TetGen : mesh4d::CapMethod::Cone},
                    swept);
  EXPECT_TRUE(report) << report.error().text();
  return swept;
}

model::Mesh copyOf(const model::Source& source) {
  model::Mesh mesh;
  EXPECT_TRUE(model::pump(source, mesh));
  return mesh;
}

/// Checks what must hold for every resolved body.
void expectSound(const model::Mesh& obstacle, const model::Mesh& before, const model::Mesh& after) {
  const model::Body a{"obstacle", &obstacle};
  const auto again = resolve({&a, 1}, {"body", &after}, {});
  ASSERT_TRUE(again) << again.error().text();
  EXPECT_FALSE(again->report.changed);
  const auto checked = measure::checkMesh(after);
  ASSERT_TRUE(checked) << checked.error().text();
  EXPECT_TRUE(checked->valid());
  EXPECT_TRUE(checked->closed && checked->oriented);
  for (double time = 0; time <= 1; time += 1.0 / 32) {
    const auto slice = slice::sliceAtTime(after, time);
    ASSERT_TRUE(slice) << slice.error().text();
    EXPECT_TRUE(isClosed(slice->mesh));
    if (!findsCrossings()) continue;
    const auto light = slice::LightSlicer(after).at(time);
    EXPECT_TRUE(findCrossings(light->slice.mesh, 1)->pairs.empty()) << time;
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
  model::Mesh plate =
      moved(placed(fixtures::paperCube(1), {4, 8, 0.5}, {2.6, 0, 0}), {0, 0, 0}, 0, 1);
  model::Mesh ball =
      moved(placed(fixtures::icosphere(1, 3), {1, 1, 1}, {0, 0, -4}), {0, 0, 8}, 0, 32);
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

TEST(Resolve, DentThatStaysNeverShrinks) {
  const BallAndPlate given;
  const model::Body plate{"plate", &given.plate};
  const auto resolved =
      resolve({&plate, 1}, {"ball", &given.ball}, {.smoothTime = 0.1, .stay = true});
  ASSERT_TRUE(resolved) << resolved.error().text();
  expectSound(given.plate, given.ball, copyOf(*resolved->source));
  double before = 0;
  for (const ResolvedLayer& layer : resolved->report.layers) {
    EXPECT_GE(layer.displacement, before * (1 - 1e-12));
    before = layer.displacement;
  }
  EXPECT_GT(before, 0.39);
}

TEST(Resolve, BlockInTheWayOfATurningBarGivesWayToTheDepthOfTheBar) {
  // The bar's tip reaches 3 from the axis, the block begins at 2.8 and is as wide as it is deep.
  const model::Mesh bar =
      moved(placed(fixtures::paperCube(1), {6, 0.4, 0.4}, {0, 0, 0}), {0, 0, 0}, 90, 24);
  const model::Mesh block = moved(
      placed(fixtures::icosphere(1, 3), {1, 1, 1}, Point3(std::cos(0.8), std::sin(0.8), 0) * 3.8),
      {0, 0, 0}, 0, 24);
  const model::Body obstacle{"bar", &bar};
  const auto resolved = resolve({&obstacle, 1}, {"block", &block}, {.smoothTime = 0.15});
  ASSERT_TRUE(resolved) << resolved.error().text();
  const model::Mesh after = copyOf(*resolved->source);
  expectSound(bar, block, after);
  expectLittleMoved(block, after, resolved->report);
  EXPECT_GT(resolved->report.maxDisplacement, 0.19);
  EXPECT_LT(resolved->report.maxDisplacement, 0.4);
}

TEST(Resolve, GapOfAMechanismIsKept) {
  // A slider runs along a rail, 0.05 above it; 0.2 are wanted.
  const model::Mesh rail =
      moved(placed(fixtures::paperCube(1), {12, 2, 1}, {0, 0, -0.55}), {0, 0, 0}, 0, 1);
  const model::Mesh slider =
      moved(placed(fixtures::icosphere(1, 3), {1, 1, 1}, {-3, 0, 1}), {6, 0, 0}, 0, 8);
  const model::Body obstacle{"rail", &rail};
  const ResolveOptions options{.clearance = 0.2};
  const auto resolved = resolve({&obstacle, 1}, {"slider", &slider}, options);
  ASSERT_TRUE(resolved) << resolved.error().text();
  EXPECT_TRUE(resolved->report.changed);
  const model::Mesh after = copyOf(*resolved->source);
  expectSound(rail, slider, after);
  const auto collision = measure::collide(rail, after);
  ASSERT_TRUE(collision && collision->clearance);
  EXPECT_GE(collision->clearance->lowerBound, 0.2);
  EXPECT_LT(collision->clearance->distance, 0.21);
  // The whole of its time: the ends are filled anew.
  EXPECT_GT(resolved->report.layers.front().displacement, 0.1);
}

TEST(Resolve, ThinObstacleBetweenTwoLayersDividesTheStep) {
  // The bullet passes the sheet within one of the sheet's steps.
  const model::Mesh bullet =
      moved(placed(fixtures::icosphere(0.2, 1), {1, 1, 1}, {0, 0.95, -8}), {0, 0, 16}, 0, 1);
  const model::Mesh sheet =
      moved(placed(fixtures::icosphere(1, 3), {1, 1, 0.3}, {0, 0, 0}), {0, 0, 0}, 0, 2);
  const model::Body obstacle{"bullet", &bullet};
  const auto resolved = resolve({&obstacle, 1}, {"sheet", &sheet}, {.smoothTime = 0.05});
  ASSERT_TRUE(resolved) << resolved.error().text();
  const model::Mesh after = copyOf(*resolved->source);
  expectSound(bullet, sheet, after);
  EXPECT_EQ(resolved->report.layers.front().displacement, 0);
  EXPECT_EQ(resolved->report.layers.back().displacement, 0);
}

/// The mesh with attributes of its layers: ten times the number of the vertex and the time, and the
/// number of the layer in steps of a third.
model::Mesh withNumbersAndTimes(const model::Mesh& mesh) {
  model::Mesh made;
  for (model::Slab slab : mesh.slabs()) {
    const model::Connectivity& connectivity = *slab.connectivity;
    std::vector<double> rows(slab.vertices.size(), -1);
    for (std::uint32_t i = 0; i < connectivity.lowerCount; ++i) rows[i] = 10 * i + slab.timeBegin;
    for (std::uint32_t i = 0; i < connectivity.upperCount; ++i) {
      rows[connectivity.firstUpper() + i] = 10 * i + slab.timeEnd;
    }
    slab.attributes.push_back(model::makeAttribute("heat", model::Domain::Vertex, rows));
    std::vector<std::int32_t> layers(slab.vertices.size(), -1);
    const auto layerAt = [](double time) {
      return static_cast<std::int32_t>(std::lround(3 * time));
    };
    std::fill_n(layers.begin(), connectivity.lowerCount, layerAt(slab.timeBegin));
    std::fill_n(layers.begin() + connectivity.firstUpper(), connectivity.upperCount,
                layerAt(slab.timeEnd));
    slab.attributes.push_back(model::makeAttribute("layer", model::Domain::Vertex, layers));
    EXPECT_TRUE(made.put(slab));
  }
  return made;
}

TEST(Resolve, AttributesStayWithTheirVerticesInNewLayersAndEnds) {
  const BallAndPlate given;
  const model::Body plate{"plate", &given.plate};
  // Some of the steps are so long that they are divided; what moves does not come back, so the end
  // is filled anew.
  const model::Mesh ball = withNumbersAndTimes(
      moved(placed(fixtures::icosphere(1, 3), {1, 1, 1}, {0, 0, -4}), {0, 0, 8}, 0, 3));
  const auto resolved = resolve({&plate, 1}, {"ball", &ball}, {.smoothTime = 0.1, .stay = true});
  ASSERT_TRUE(resolved) << resolved.error().text();
  EXPECT_GT(resolved->report.addedLayers, 0U);
  EXPECT_GT(resolved->report.layers.back().displacement, 0);
  const model::Mesh after = copyOf(*resolved->source);
  for (const model::Slab& slab : after.slabs()) {
    const model::Connectivity& connectivity = *slab.connectivity;
    const auto heat = std::ranges::find(slab.attributes, "heat", &model::Attribute::name);
    ASSERT_NE(heat, slab.attributes.end());
    ASSERT_EQ(heat->rows(), connectivity.vertexCount);
    const auto at = [&](std::uint32_t row) {
      double value = 0;
      std::memcpy(&value, heat->row(row), sizeof value);
      return value;
    };
    for (std::uint32_t i = 0; i < connectivity.lowerCount; ++i) {
      EXPECT_NEAR(at(i), 10 * i + slab.timeBegin, 1e-9);
    }
    for (std::uint32_t i = 0; i < connectivity.upperCount; ++i) {
      EXPECT_NEAR(at(connectivity.firstUpper() + i), 10 * i + slab.timeEnd, 1e-9);
    }
    // Numbers that cannot be between two keep that of the layer before.
    const auto layer = std::ranges::find(slab.attributes, "layer", &model::Attribute::name);
    ASSERT_NE(layer, slab.attributes.end());
    const auto expectLayer = [&](std::uint32_t first, std::uint32_t count, double time) {
      for (std::uint32_t i = first; i < first + count; ++i) {
        std::int32_t value = 0;
        std::memcpy(&value, layer->row(i), sizeof value);
        ASSERT_EQ(value, static_cast<std::int32_t>(std::floor(3 * time + 1e-9))) << time;
      }
    };
    expectLayer(0, connectivity.lowerCount, slab.timeBegin);
    expectLayer(connectivity.firstUpper(), connectivity.upperCount, slab.timeEnd);
  }
}

TEST(DisplacedSource, PoseOfALayerIsNotThatOfOneWithinTheStepBefore) {
  const model::Mesh cube = moved(fixtures::cube(1), {1, 0, 0}, 30, 1);
  const auto tracks = VertexTracks::of(cube);
  ASSERT_TRUE(tracks) << tracks.error().text();
  const model::Slab& step = cube.slabs()[1];
  ASSERT_TRUE(step.upperPose);
  const DisplacedSource divided(*tracks, {{LayerKey{0, 0.5}, {}}}, false);
  ASSERT_EQ(divided.slabCount(), cube.slabCount() + 1);
  EXPECT_FALSE((*divided.slab(1))->upperPose);
  EXPECT_TRUE((*divided.slab(2))->upperPose == step.upperPose);
}

TEST(Resolve, BodyThatIsClearIsLeftAsItIs) {
  const BallAndPlate given;
  const model::Mesh far = moved(placed(fixtures::cube(1), {1, 1, 1}, {9, 0, 0}), {0, 0, 1}, 0, 2);
  const model::Body plate{"plate", &given.plate};
  const auto resolved = resolve({&plate, 1}, {"far", &far}, {.clearance = 0.5});
  ASSERT_TRUE(resolved) << resolved.error().text();
  EXPECT_FALSE(resolved->report.changed);
  EXPECT_EQ(resolved->source.get(), &far);
}

TEST(Resolve, BodyWithoutAWayOutIsRefusedWithTimeAndPlace) {
  const model::Mesh room = moved(fixtures::cube(9), {0, 0, 0}, 0, 2);
  const model::Mesh ball = moved(fixtures::icosphere(1, 2), {1, 0, 0}, 0, 4);
  const model::Body obstacle{"room", &room};
  const auto resolved = resolve({&obstacle, 1}, {"ball", &ball}, {});
  ASSERT_FALSE(resolved);
  EXPECT_EQ(resolved.error().code, ErrorCode::Failed);
  EXPECT_NE(resolved.error().message.find("at time"), std::string::npos)
      << resolved.error().message;
  EXPECT_NE(resolved.error().message.find("no way out"), std::string::npos);
}

TEST(Resolve, LawOfPrismsGivesTheChangeOfTheHypervolume) {
  const BallAndPlate given;
  const model::Body plate{"plate", &given.plate};
  const auto resolved = resolve({&plate, 1}, {"ball", &given.ball}, {});
  ASSERT_TRUE(resolved) << resolved.error().text();
  const model::Mesh after = copyOf(*resolved->source);
  double sum = 0;
  for (const auto& [mesh, sign] : {std::pair(&after, 1.0), std::pair(&given.ball, -1.0)}) {
    for (const model::Slab& slab : mesh->slabs()) {
      if (!(slab.timeBegin < slab.timeEnd)) continue;
      const auto volume = [&](double time) {
        return signedVolume(slice::sliceAtTime(*mesh, time)->mesh);
      };
      const double middle = (slab.timeBegin + slab.timeEnd) / 2;
      sum += sign * (slab.timeEnd - slab.timeBegin) / 6 *
             (volume(slab.timeBegin) + 4 * volume(middle) + volume(slab.timeEnd));
    }
  }
  EXPECT_NEAR(resolved->report.hypervolumeChange, sum, 1e-10);
}

}  // namespace
}  // namespace t4d::edit
