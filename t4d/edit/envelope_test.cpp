#include "t4d/edit/envelope.h"

#include <cmath>
#include <filesystem>
#include <numbers>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "t4d/edit/surface_crossings.h"
#include "t4d/fixtures/motions.h"
#include "t4d/fixtures/solids.h"
#include "t4d/formats/motion_reader.h"
#include "t4d/formats/triangle_mesh_reader.h"
#include "t4d/measure/winding_number.h"
#include "t4d/mesh4d/sweep.h"
#include "t4d/model/surface_check.h"
#include "tests/paths.h"

namespace t4d::edit {
namespace {

using measure::Silhouette;
using model::Point3;
using model::TriangleMesh;

Silhouette silhouetteOfScrew(const TriangleMesh& solid, const model::Screw& screw,
                             std::uint64_t count = 1, std::uint64_t steps = 0) {
  const model::ScrewRun run{1, screw, count};
  const auto motion = model::chainScrews(0, {&run, 1});
  EXPECT_TRUE(motion);
  mesh4d::SweepOptions options;
  if (steps > 0) options.steps = mesh4d::StepsPerSegment{steps};
  measure::SilhouetteBuilder builder;
  EXPECT_TRUE(mesh4d::sweep(solid, *motion, options, builder));
  auto silhouette = builder.finish();
  EXPECT_TRUE(silhouette);
  return std::move(*silhouette);
}

Envelope made(const Silhouette& silhouette, const EnvelopeOptions& options) {
  auto envelope = envelopeOf(silhouette, options);
  EXPECT_TRUE(envelope) << (envelope ? "" : envelope.error().text());
  if (!envelope) return {};
  EXPECT_TRUE(model::checkClosedSurface(envelope->mesh));
  EXPECT_TRUE(findCrossings(envelope->mesh, 10)->none());
  return std::move(*envelope);
}

/// The area of a convex solid seen along a direction, times its length.
double shadow(const TriangleMesh& solid, const Point3& direction) {
  double area = 0;
  for (const auto& [a, b, c] : solid.triangles) {
    const Point3 normal =
        (solid.vertices[b] - solid.vertices[a]).cross(solid.vertices[c] - solid.vertices[a]);
    area += std::abs(normal.dot(direction)) / 4;
  }
  return area;
}

TEST(Envelope, OfThePapersCubeIsABoxOf33600) {
  const Silhouette silhouette =
      silhouetteOfScrew(fixtures::paperCube(), {.translation = {0, 0, 1}}, 64);
  for (const double voxelSize : {0.7, 2.1}) {
    const Envelope envelope = made(silhouette, {.voxelSize = voxelSize});
    EXPECT_NEAR(envelope.volume, 33600, 1e-6);
    EXPECT_EQ(envelope.components, 1);
    EXPECT_EQ(envelope.genus, 0);
  }
  const Envelope exact = made(silhouette, {.exact = true});
  EXPECT_NEAR(exact.volume, 33600, 1e-7);
}

TEST(Envelope, OfAConvexSolidMovedStraightHasItsVolumePlusLengthTimesShadow) {
  const TriangleMesh solid = fixtures::icosphere(2, 2);
  for (const Point3& along : {Point3(3, 1, 2), Point3(-1, 5, 0.3), Point3(0.2, 0.1, -6)}) {
    const Silhouette silhouette = silhouetteOfScrew(solid, {.translation = along});
    const double expected = model::signedVolume(solid) + shadow(solid, along);
    for (const double voxelSize : {0.4, 0.2}) {
      const Envelope envelope = made(silhouette, {.voxelSize = voxelSize});
      EXPECT_NEAR(envelope.volume / expected, 1, 0.02 * voxelSize * voxelSize);
      EXPECT_EQ(envelope.errorBound, std::numbers::sqrt3 * voxelSize);
    }
  }
}

TEST(Envelope, OfAPrismTurnedAboutItsAxisHasThePolygonOfTheStepsAsItsBase) {
  const TriangleMesh prism = fixtures::cube(2);
  const Silhouette silhouette = silhouetteOfScrew(prism, {.angleDegrees = 360}, 1, 20);
  // The corners visit the corners of a regular polygon of 20 sides.
  const double base = 20 * std::sin(2 * std::numbers::pi / 20);
  EXPECT_NEAR(made(silhouette, {.voxelSize = 0.05}).volume / (2 * base), 1, 2e-3);
}

TEST(Envelope, OfABallOnACircleIsATorusWithItsHoleOpen) {
  TriangleMesh ball = fixtures::icosphere(1, 3);
  for (Point3& vertex : ball.vertices) vertex.x() += 3;
  const Silhouette silhouette = silhouetteOfScrew(ball, {.angleDegrees = 360}, 1, 72);
  const double torus = 2 * std::numbers::pi * std::numbers::pi * 3;
  for (const double voxelSize : {0.2, 0.1}) {
    const Envelope envelope = made(silhouette, {.voxelSize = voxelSize});
    EXPECT_EQ(envelope.genus, 1);
    EXPECT_EQ(envelope.components, 1);
    EXPECT_EQ(envelope.cavities, 0);
    EXPECT_NEAR(envelope.volume / torus, 1, 0.02);
  }
}

TEST(Envelope, OfThePapersScrewLiesBetweenTheSolidAndItsVisits) {
  const std::filesystem::path path = std::filesystem::path(T4D_SHARED_MESHES) / "fish.obj";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no file " << path;
  const auto fish = formats::readTriangleMesh(path);
  ASSERT_TRUE(fish) << fish.error().text();
  const auto motions = fixtures::allMotions();
  const auto screw = std::find_if(motions.begin(), motions.end(),
                                  [](const auto& motion) { return motion.name == "paper-screw"; });
  ASSERT_NE(screw, motions.end());
  const auto motion = formats::parseMotion(screw->json, screw->name);
  ASSERT_TRUE(motion) << motion.error().text();
  measure::SilhouetteBuilder builder;
  ASSERT_TRUE(mesh4d::sweep(fish->mesh, *motion, {.caps = mesh4d::CapMethod::Cone}, builder));
  const auto silhouette = builder.finish();
  ASSERT_TRUE(silhouette) << silhouette.error().text();
  const Envelope envelope = made(*silhouette, {});
  EXPECT_GT(envelope.volume, model::signedVolume(fish->mesh));
  EXPECT_LT(envelope.volume, silhouette->visitsVolume);
  EXPECT_EQ(envelope.components, 1);
}

TEST(Envelope, CountsPlacesThatAreVisitedTwiceOnce) {
  TriangleMesh cube = fixtures::cube(1);
  for (Point3& vertex : cube.vertices) vertex.x() += 3;
  const Envelope once =
      made(silhouetteOfScrew(cube, {.angleDegrees = 360}, 1, 36), {.voxelSize = 0.1});
  const Silhouette more = silhouetteOfScrew(cube, {.angleDegrees = 540}, 1, 54);
  const Envelope twice = made(more, {.voxelSize = 0.1});
  EXPECT_NEAR(twice.volume / once.volume, 1, 1e-3);
  EXPECT_GT(more.visitsVolume, 1.4 * once.volume);
}

TEST(Envelope, IsTheSameFarFromTheOriginAndForTinyAndHugeBodies) {
  const TriangleMesh solid = fixtures::icosphere(2, 1);
  const double expected = model::signedVolume(solid) + shadow(solid, {1, 2, 3});
  for (const double scale : {1e-60, 1e-6, 1.0, 1e6, 1e60}) {
    TriangleMesh body = solid;
    for (Point3& vertex : body.vertices) vertex *= scale;
    const Silhouette silhouette = silhouetteOfScrew(body, {.translation = Point3(1, 2, 3) * scale});
    const Envelope envelope = made(silhouette, {.voxelSize = 0.25 * scale});
    EXPECT_NEAR(envelope.volume / scale / scale / scale / expected, 1, 2e-3);
  }
  TriangleMesh far = solid;
  for (Point3& vertex : far.vertices) vertex += Point3(1e6, -1e6, 1e6);
  const Silhouette silhouette = silhouetteOfScrew(far, {.translation = {1, 2, 3}});
  EXPECT_NEAR(made(silhouette, {.voxelSize = 0.25}).volume / expected, 1, 2e-3);
  const auto coarse =
      envelopeOf(silhouette, {.voxelSize = 0.25, .singlePrecisionAbout = Point3::Zero()});
  ASSERT_FALSE(coarse);
  EXPECT_EQ(coarse.error().text(),
            "rounding the vertices to float32 makes triangles cross: a voxel size of 0.25 is too "
            "small for coordinates of this size; 1 works");
  EXPECT_NEAR(
      made(silhouette, {.voxelSize = 0.25, .singlePrecisionAbout = Point3(1e6, -1e6, 1e6)}).volume /
          expected,
      1, 2e-3);
}

TEST(Envelope, RefusesAVoxelSizeThatNeedsTooMuchMemoryAndSaysOneThatFits) {
  const Silhouette silhouette =
      silhouetteOfScrew(fixtures::paperCube(), {.translation = {0, 0, 1}}, 64);
  const auto refused = envelopeOf(silhouette, {.voxelSize = 0.01});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().text(),
            "a voxel size of 0.01 would need about 56.1 GiB of memory, more than 4 GiB; 0.038 "
            "fits");
  const auto never = envelopeOf(silhouette, {.voxelSize = 1, .maxBytes = 1});
  ASSERT_FALSE(never);
  EXPECT_TRUE(never.error().text().ends_with("; no voxel size fits")) << never.error().text();
  const auto tooMany = envelopeOf(silhouette, {.voxelSize = 1e-7});
  ASSERT_FALSE(tooMany);
  EXPECT_TRUE(tooMany.error().text().ends_with("; 0.038 fits")) << tooMany.error().text();
}

TEST(Envelope, OfASmallSolidThatMovesFarIsFound) {
  const TriangleMesh pin = fixtures::cube(0.01);
  const Silhouette along = silhouetteOfScrew(pin, {.translation = {10, 0, 0}});
  const Envelope found = made(along, {});
  EXPECT_EQ(found.voxelSize, 0.0025);
  EXPECT_NEAR(found.volume, 0.001001, 1e-9);
  EXPECT_EQ(found.components, 1);
  EXPECT_TRUE(found.losses.empty());
  const auto lost = envelopeOf(along, {.voxelSize = 0.5});
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().text(), "a voxel size of 0.5 finds nothing of the solid; 0.0025 finds it");
  EXPECT_EQ(lost.error().code, ErrorCode::Failed);

  const Silhouette diagonal = silhouetteOfScrew(pin, {.translation = {1, 1, 1}});
  EXPECT_TRUE(made(diagonal, {}).losses.empty());
  const Envelope pieces = made(diagonal, {.voxelSize = 0.02});
  ASSERT_EQ(pieces.losses.size(), 2);
  EXPECT_EQ(pieces.losses[0],
            "parts of the solid may be missing: one is only 0.01 wide, and a voxel is 0.02");
  EXPECT_EQ(pieces.losses[1],
            fmt::format("voxels of 0.02 are too large: the envelope is in {} pieces, but no more "
                        "than 1 can be",
                        pieces.components));
}

TEST(Envelope, SaysThatTheSolidItselfHasMoreVolume) {
  // Crossed thin plates, of which one lies between the planes of the lattice.
  TriangleMesh solid = fixtures::cube(1);
  TriangleMesh plate = fixtures::cube(1);
  for (Point3& vertex : plate.vertices) {
    vertex = {10 * vertex.x(), 10 * vertex.y(), 0.4 * vertex.z() + 5.3};
  }
  const auto first = static_cast<std::uint32_t>(solid.vertices.size());
  solid.vertices.insert(solid.vertices.end(), plate.vertices.begin(), plate.vertices.end());
  for (const auto& [a, b, c] : plate.triangles) {
    solid.triangles.push_back({a + first, b + first, c + first});
  }
  const Silhouette silhouette = silhouetteOfScrew(solid, {.translation = {0.1, 0, 0}});
  EXPECT_NEAR(silhouette.solidVolume, 41, 1e-9);
  EXPECT_NEAR(silhouette.partExtent, 0.4, 1e-12);
  EXPECT_TRUE(made(silhouette, {}).losses.empty());
}

TEST(Envelope, OfAMeshWithoutVolumeIsEmpty) {
  const auto envelope = envelopeOf({}, {});
  ASSERT_TRUE(envelope);
  EXPECT_TRUE(envelope->mesh.triangles.empty());
}

}  // namespace
}  // namespace t4d::edit
