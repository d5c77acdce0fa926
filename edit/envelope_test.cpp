#include "t4d/envelope.h"

#include <cmath>
#include <filesystem>
#include <numbers>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "edit/collision_mesh.h"
#include "edit/reduce_surface.h"
#include "edit/surface_crossings.h"
#include "fixtures/motions.h"
#include "fixtures/solids.h"
#include "measure/chord_bound.h"
#include "measure/enclosure.h"
#include "measure/visit_lattice.h"
#include "measure/winding_number.h"
#include "model/surface_check.h"
#include "t4d/motion.h"
#include "t4d/surface.h"
#include "t4d/sweep.h"
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
  for (const double scale : {1e-29, 1e-6, 1.0, 1e6, 1e30}) {
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
            "with a voxel size of 0.01 the envelope needs about 60.19 GB of memory, more than the "
            "limit of 4.00 GB; 0.039 fits");
  const auto never = envelopeOf(silhouette, {.voxelSize = 1, .maxBytes = 1});
  ASSERT_FALSE(never);
  EXPECT_TRUE(never.error().text().ends_with("; no voxel size fits")) << never.error().text();
  const auto tooMany = envelopeOf(silhouette, {.voxelSize = 1e-7});
  ASSERT_FALSE(tooMany);
  EXPECT_TRUE(tooMany.error().text().ends_with("; 0.039 fits")) << tooMany.error().text();
  const auto far = envelopeOf(silhouette, {.voxelSize = 1e-30});
  ASSERT_FALSE(far);
  EXPECT_TRUE(far.error().text().ends_with(" fits")) << far.error().text();
  for (const double size : {1e-308, 5e-324, 1e31}) {
    const auto impossible = envelopeOf(silhouette, {.voxelSize = size});
    ASSERT_FALSE(impossible);
    EXPECT_TRUE(impossible.error().text().ends_with("1e-30 to 1e+30 are possible"));
    EXPECT_EQ(impossible.error().remedy, Remedy::VoxelSize);
  }
}

TEST(Envelope, OfASmallSolidThatMovesFarIsFound) {
  const TriangleMesh pin = fixtures::cube(0.01);
  const Silhouette along = silhouetteOfScrew(pin, {.translation = {10, 0, 0}});
  const Envelope found = made(along, {});
  EXPECT_EQ(found.voxelSize, 0.0025);
  EXPECT_NEAR(found.volume, 0.001001, 1e-9);
  EXPECT_EQ(found.components, 1);
  EXPECT_TRUE(found.losses.empty());
  // Chosen voxels that are not larger than the pin may be larger than a default.
  EXPECT_TRUE(made(along, {.voxelSize = 0.006}).losses.empty());
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

TEST(Envelope, OfSeveralBodiesTakesTheScaleOfTheSmallest) {
  const Silhouette large = silhouetteOfScrew(fixtures::cube(8), {.translation = {1, 0, 0}});
  const Silhouette small = silhouetteOfScrew(fixtures::cube(2), {.translation = {1, 0, 0}});
  for (const auto& [first, second] : {std::pair(&large, &small), std::pair(&small, &large)}) {
    Silhouette both = *first;
    add(both, *second);
    EXPECT_EQ(both.solidExtent, small.solidExtent);
    EXPECT_EQ(both.partExtent, small.partExtent);
    EXPECT_EQ(both.solidVolume, large.solidVolume);
    EXPECT_EQ(both.exits, large.exits + small.exits);
    EXPECT_DOUBLE_EQ(both.visitsVolume, large.visitsVolume + small.visitsVolume);
    Silhouette alone;
    add(alone, *first);
    EXPECT_EQ(alone.solidExtent, first->solidExtent);
  }
}

TEST(Envelope, OfAMeshWithoutVolumeIsEmpty) {
  const auto envelope = envelopeOf({}, {});
  ASSERT_TRUE(envelope);
  EXPECT_TRUE(envelope->mesh.triangles.empty());
}

/// A solid, swept, and its envelope that contains the motion.
struct Outside {
  model::Motion motion;
  Envelope envelope;
  double chordBound = 0;
};

Outside outsideOf(const TriangleMesh& solid, const model::Screw& screw, std::uint64_t steps,
                  EnvelopeOptions options) {
  const model::ScrewRun run{1, screw, 1};
  auto motion = model::chainScrews(0, {&run, 1});
  EXPECT_TRUE(motion);
  model::Mesh mesh;
  EXPECT_TRUE(mesh4d::sweep(
      solid, *motion, {.steps = mesh4d::StepsPerSegment{steps}, .caps = mesh4d::CapMethod::Cone},
      mesh));
  const auto silhouette = measure::silhouetteOf(mesh);
  EXPECT_TRUE(silhouette) << silhouette.error().text();
  const auto bound = measure::chordBound(mesh, {0, 1});
  EXPECT_TRUE(bound && *bound);
  options.reach = (*bound)->bound + (*bound)->rounding;
  return {std::move(*motion), made(*silhouette, options), *options.reach};
}

/// Looks for places of the true motion that are not within, among the corners, the middles of edges
/// and places on faces of the solid, at many times.
void expectWithin(const Outside& outside, const TriangleMesh& solid, int times,
                  std::size_t stride = 1) {
  const measure::WindingNumber winding(outside.envelope.mesh);
  std::size_t out = 0;
  for (int k = 0; k <= times; ++k) {
    const double time = static_cast<double>(k) / times;
    const auto pose = outside.motion.at(time);
    for (std::size_t i = k % stride; i < solid.triangles.size(); i += stride) {
      const auto& [a, b, c] = solid.triangles[i];
      const Point3& p = solid.vertices[a];
      const Point3& q = solid.vertices[b];
      const Point3& r = solid.vertices[c];
      for (const Point3& point : {p, Point3((p + q) / 2), Point3((p + q + r) / 3),
                                  Point3(0.8 * p + 0.15 * q + 0.05 * r)}) {
        const Point3 place = pose(point);
        if (std::abs(winding.at(place)) > 0.75) continue;
        out += winding.exactAt(place) > 0.5 ? 0 : 1;
      }
    }
  }
  EXPECT_EQ(out, 0);
}

TEST(Envelope, OutsideContainsTheTrueMotion) {
  TriangleMesh plate = fixtures::cube(2);
  for (Point3& v : plate.vertices) v = {5 * v.x(), 3 * v.y(), 0.01 * v.z() + 2};
  const TriangleMesh bar = fixtures::translated(fixtures::cube(1), {4, 0, 0});
  const model::Screw turn{{0, 0, 0}, Point3::UnitZ(), 90, {0, 0, 1}};
  const model::Screw skew{{0.5, 1, 0}, Point3(1, 2, -1).normalized(), 300, {2, 1, 0.5}};
  const model::Screw straight{{0, 0, 0}, Point3::UnitZ(), 0, {3, 1, -2}};
  for (const TriangleMesh& solid :
       {bar, plate, fixtures::pebble(1.5, 60), fixtures::torus(2, 0.5, 9, 6)}) {
    for (const auto& [screw, steps] :
         {std::pair(turn, 1U), std::pair(turn, 7U), std::pair(skew, 5U), std::pair(straight, 1U)}) {
      for (const double voxelSize : {0.6, 1.3}) {
        for (const bool single : {false, true}) {
          SCOPED_TRACE(testing::Message() << steps << " " << voxelSize << " " << single);
          EnvelopeOptions options{.voxelSize = voxelSize};
          if (single) options.singlePrecisionAbout = Point3(0.1, 0, 0);
          const Outside outside = outsideOf(solid, screw, steps, options);
          expectWithin(outside, solid, 31);
          // The surface is as near as it says, and no nearer than it must be.
          EXPECT_GE(outside.envelope.errorBound, outside.chordBound);
          EXPECT_LE(outside.envelope.errorBound,
                    outside.chordBound + 1.85 * outside.envelope.voxelSize);
        }
      }
    }
  }
}

TEST(Envelope, OutsideContainsTheTrueMotionOfRealMeshes) {
  const model::Screw screw{{0, 1, 0}, Point3(1, 3, 2).normalized(), 140, {0.3, 0.1, 0.2}};
  for (const char* name : {"fish_low_resolution.obj", "spot_low_resolution.obj", "wingnut.obj"}) {
    const std::filesystem::path path = std::filesystem::path(T4D_SHARED_MESHES) / name;
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no file " << path;
    const auto read = formats::readTriangleMesh(path);
    ASSERT_TRUE(read) << read.error().text();
    SCOPED_TRACE(name);
    const model::Bounds3 bounds = model::boundsOf(read->mesh);
    const double size = (bounds.max - bounds.min).maxCoeff();
    const Outside outside = outsideOf(read->mesh, screw, 5, {.voxelSize = size / 20});
    expectWithin(outside, read->mesh, 20, 1 + read->mesh.triangles.size() / 100);
  }
}

TEST(Envelope, OutsideHasWhatIsThinnerThanVoxels) {
  TriangleMesh sheet = fixtures::cube(2);
  for (Point3& v : sheet.vertices) v = {10 * v.x(), 7 * v.y(), 1e-6 * v.z()};
  const Outside outside = outsideOf(sheet, {.translation = {0.5, 0, 0}}, 1, {.voxelSize = 0.5});
  expectWithin(outside, sheet, 5);
  EXPECT_EQ(outside.envelope.components, 1);
  EXPECT_TRUE(outside.envelope.losses.empty());
  const auto lost =
      envelopeOf(silhouetteOfScrew(sheet, {.translation = {0.5, 0, 0}}), {.voxelSize = 0.5});
  ASSERT_FALSE(lost);
  EXPECT_THAT(lost.error().message, testing::HasSubstr("5e-07 may find it"));
}

TEST(Envelope, OfASheetTakesADefaultThatFitsItsTime) {
  // Quarters of their thickness would take minutes or hours.
  for (const double thickness : {1.0, 0.002}) {
    TriangleMesh sheet = fixtures::cube(1);
    for (Point3& v : sheet.vertices) v = {300 * v.x(), 200 * v.y(), thickness * v.z()};
    const Silhouette silhouette =
        silhouetteOfScrew(sheet, {{0, 0, 0}, Point3(1, 2, 3).normalized(), 90, {0, 0, 20}});
    const double size = defaultVoxelSize(silhouette, {});
    EXPECT_GT(size, thickness / 4);
    auto lattice = measure::SpaceLattice::about(model::boundsOf(silhouette.surface), size);
    ASSERT_TRUE(lattice);
    EXPECT_LE(measure::VisitLattice::estimatedSeconds(silhouette.surface, *lattice),
              EnvelopeOptions().defaultSeconds);
    EXPECT_EQ(size, defaultVoxelSize(silhouette, {.maxBytes = 1e12}));
  }
}

TEST(Envelope, OfATiltedPlateTakesADefaultThatFitsItsThickness) {
  TriangleMesh plate = fixtures::cube(1);
  const Eigen::Matrix3d tilt =
      Eigen::AngleAxisd(0.6, Point3(1, 2, 0.3).normalized()).toRotationMatrix();
  for (Point3& v : plate.vertices) v = tilt * Point3(20 * v.x(), 20 * v.y(), 0.5 * v.z());
  const Point3 along = tilt * Point3(30, 0, 0);
  const Silhouette silhouette =
      silhouetteOfScrew(plate, {.translation = {along.x(), along.y(), along.z()}});
  EXPECT_NEAR(silhouette.partExtent, 0.5, 1e-9);
  const auto envelope = envelopeOf(silhouette, {});
  ASSERT_TRUE(envelope) << envelope.error().text();
  EXPECT_EQ(envelope->components, 1U);
  EXPECT_EQ(envelope->genus, 0);
  EXPECT_NEAR(envelope->volume, 50 * 20 * 0.5, 0.001 * 500);
  EXPECT_TRUE(envelope->losses.empty());
  const auto coarse = envelopeOf(silhouette, {.voxelSize = 2});
  ASSERT_TRUE(coarse);
  EXPECT_NE(coarse->losses.front().find("thinner than a voxel of 2 are missing"),
            std::string::npos);
}

TEST(Envelope, OutsideTakesNoSmallerDefaultForThinParts) {
  TriangleMesh rod = fixtures::cube(1);
  for (Point3& v : rod.vertices) v = {10 * v.x(), 0.01 * v.y(), 0.01 * v.z()};
  const Silhouette silhouette = silhouetteOfScrew(rod, {.translation = {0, 1, 0}});
  const double thin = defaultVoxelSize(silhouette, {});
  const double usual = defaultVoxelSize(silhouette, {.reach = 0});
  EXPECT_LT(thin, 0.01);
  EXPECT_GT(usual, 10.0 / 64);
  EXPECT_EQ(defaultVoxelSize(silhouette, {.reach = 1}), usual);
  EXPECT_EQ(defaultVoxelSize(silhouette, {.reach = 8}), 1);
}

/// The envelope of a solid moved by a screw, simplified to at most `triangles` triangles.
Outside simplified(const TriangleMesh& solid, const model::Screw& screw, std::uint64_t steps,
                   std::size_t triangles, EnvelopeOptions options = {}) {
  const model::ScrewRun run{1, screw, 1};
  auto motion = model::chainScrews(0, {&run, 1});
  EXPECT_TRUE(motion);
  model::Mesh mesh;
  EXPECT_TRUE(mesh4d::sweep(
      solid, *motion, {.steps = mesh4d::StepsPerSegment{steps}, .caps = mesh4d::CapMethod::Cone},
      mesh));
  const auto silhouette = measure::silhouetteOf(mesh);
  EXPECT_TRUE(silhouette);
  const auto bound = measure::chordBound(mesh, {0, 1});
  EXPECT_TRUE(bound && *bound);
  options.reach = (*bound)->bound + options.reach.value_or(0);
  auto envelope = collisionMeshOf(*silhouette, options, triangles);
  EXPECT_TRUE(envelope) << (envelope ? "" : envelope.error().text());
  if (!envelope) return {};
  EXPECT_TRUE(model::checkClosedSurface(envelope->mesh));
  EXPECT_TRUE(findCrossings(envelope->mesh, 10)->none());
  EXPECT_LE(envelope->mesh.triangles.size(), triangles);
  return {std::move(*motion), std::move(*envelope), *options.reach};
}

TEST(CollisionMesh, ContainsTheTrueMotionWithFewTriangles) {
  if (!reducesSurfaces()) GTEST_SKIP() << "no meshoptimizer";
  TriangleMesh plate = fixtures::cube(2);
  for (Point3& v : plate.vertices) v = {5 * v.x(), 3 * v.y(), 0.01 * v.z() + 2};
  const model::Screw turn{{0, 0, 0}, Point3::UnitZ(), 90, {0, 0, 1}};
  const model::Screw skew{{0.5, 1, 0}, Point3(1, 2, -1).normalized(), 200, {2, 1, 0.5}};
  for (const TriangleMesh& solid :
       {plate, fixtures::pebble(1.5, 60), fixtures::torus(2, 0.5, 9, 6)}) {
    for (const auto& [screw, triangles] : {std::pair{turn, 60U}, std::pair{skew, 400U}}) {
      SCOPED_TRACE(testing::Message() << triangles << " " << screw.angleDegrees);
      const Outside outside = simplified(solid, screw, 5, triangles, {.voxelSize = 0.9});
      expectWithin(outside, solid, 11);
      EXPECT_GE(outside.envelope.errorBound, outside.chordBound);
    }
  }
}

TEST(CollisionMesh, ContainsWhatIsNearFarFromTheOriginAndInFloat32) {
  if (!reducesSurfaces()) GTEST_SKIP() << "no meshoptimizer";
  const Point3 far(3e5, -2e5, 1e5);
  const TriangleMesh bar = fixtures::translated(fixtures::cube(1), far);
  const Outside outside = simplified(bar, {far, Point3::UnitZ(), 90, {0, 0, 3}}, 8, 80,
                                     {.voxelSize = 0.3, .reach = 0.5, .singlePrecisionAbout = far});
  // Everything within half a unit, in the directions of the axes.
  for (const Point3& by : {Point3(0.5, 0, 0), Point3(0, -0.5, 0), Point3(0, 0, 0.5)}) {
    Outside moved = outside;
    for (Point3& vertex : moved.envelope.mesh.vertices) vertex += by;
    expectWithin(moved, bar, 11);
  }
}

TEST(CollisionMesh, HasNoMoreTrianglesThanAskedForOrSaysSo) {
  if (!reducesSurfaces()) GTEST_SKIP() << "no meshoptimizer";
  const Silhouette torus =
      silhouetteOfScrew(fixtures::torus(3, 0.5, 24, 12), {.translation = {0, 0, 0.5}});
  const auto mesh = collisionMeshOf(torus, {.voxelSize = 0.6, .reach = 0}, 4);
  ASSERT_TRUE(mesh) << mesh.error().text();
  EXPECT_EQ(mesh->losses.size(), mesh->mesh.triangles.size() > 4 ? 1 : 0);
  EXPECT_EQ(measure::EnclosedPlaces(torus.surface).margin(mesh->mesh, 1e-9), 1e-9);
}

TEST(CollisionMesh, EndsForVoxelsOfAnySize) {
  if (!reducesSurfaces()) GTEST_SKIP() << "no meshoptimizer";
  const Silhouette cube = silhouetteOfScrew(fixtures::cube(20), {.translation = {5, 1, 0.5}});
  for (const double size : {1e-300, 1e-30, 1e-9, 1e4, 1e6, 0x1p64, 1e30, 1e300}) {
    SCOPED_TRACE(size);
    const auto mesh = collisionMeshOf(cube, {.voxelSize = size, .reach = 0}, 60);
    if (!mesh) {
      EXPECT_FALSE(mesh.error().message.empty());
      continue;
    }
    EXPECT_GT(size, 1);
    EXPECT_TRUE(model::checkClosedSurface(mesh->mesh));
    EXPECT_GT(measure::EnclosedPlaces(cube.surface).margin(mesh->mesh, 1), 0);
  }
}

TEST(EnclosedPlaces, MarginOfLargeSurfacesIsFoundSoon) {
  const TriangleMesh inner = fixtures::translated(fixtures::cube(2), {7, 0, 0});
  const measure::EnclosedPlaces places(inner);
  for (const double side : {1e3, 1e6, 1e12, 1e20}) {
    const double margin = side / 2 - 8;
    EXPECT_NEAR(places.margin(fixtures::cube(side), 2 * side), margin, 1e-9 * margin) << side;
  }
}

TEST(EnclosedPlaces, MarginIsTheDistanceOfNestedCubesAndZeroOfOthers) {
  const TriangleMesh inner = fixtures::translated(fixtures::cube(2), {7, 0, 0});
  const measure::EnclosedPlaces places(inner);
  const TriangleMesh outer = fixtures::translated(fixtures::cube(5), {7, 0.25, 0});
  EXPECT_NEAR(places.margin(outer, 100), 1.25, 1e-12);
  EXPECT_EQ(places.margin(outer, 1), 1);
  EXPECT_EQ(places.margin(fixtures::translated(fixtures::cube(2), {8, 0, 0}), 100), 0);
  EXPECT_EQ(places.margin(fixtures::translated(fixtures::cube(2), {17, 0, 0}), 100), 0);
  EXPECT_EQ(places.margin(fixtures::translated(fixtures::cube(1), {7, 0, 0}), 100), 0);
}

TEST(Envelope, ExactAndOutsideExcludeEachOther) {
  const auto refused = envelopeOf(silhouetteOfScrew(fixtures::cube(1), {.translation = {1, 0, 0}}),
                                  {.reach = 0, .exact = true});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::Unsupported);
}

}  // namespace
}  // namespace t4d::edit
