#include <fstream>

#include <gtest/gtest.h>

#include "t4d/convert/frame_files.h"
#include "t4d/convert/morph_flipbook.h"
#include "t4d/convert/rigid_flipbook.h"
#include "t4d/fixtures/solids.h"
#include "t4d/formats/triangle/triangle_mesh_reader.h"
#include "t4d/formats/usd/usd_animation.h"
#include "t4d/mesh4d/sweep.h"
#include "t4d/system/test_folder.h"

namespace t4d::convert {
namespace {

/// A torus that is screwed by 100 degrees from time 0 to 1.
model::Mesh turnedTorus() {
  mesh4d::SweepOptions options;
  options.caps = mesh4d::CapMethod::Cone;
  options.steps = mesh4d::StepsPerSegment{4};
  model::Screw screw;
  screw.axisPoint = {1, 2, 0};
  screw.axisDirection = Eigen::Vector3d(1, 2, 2) / 3;
  screw.angleDegrees = 100;
  screw.translation = {1, 2, 3};
  const model::ScrewRun run{1, screw, 1};
  model::Mesh mesh;
  EXPECT_TRUE(
      mesh4d::sweep(fixtures::torus(3, 1, 9, 5), *model::chainScrews(0, {&run, 1}), options, mesh));
  return mesh;
}

class UsdFlipbook : public testing::Test {
 protected:
  using Write = Result<FrameSlicesReport> (*)(std::span<const model::Body>, std::span<const double>,
                                              const std::filesystem::path&, const FlipbookOptions&,
                                              const model::Progress&);

  /// Plays at the speed of the mesh's time.
  formats::AnimatedScene playedBy(Write write, const char* name = "out.usda") {
    FlipbookOptions options;
    options.framesPerSecond = 8;
    options.write.placement = {0.001, true, ""};
    const auto report = write({&body_, 1}, model::evenTimes({0, 1}, 9), path(name), options, {});
    EXPECT_TRUE(report) << report.error().text();
    auto file = formats::readInputFile(path(name));
    EXPECT_TRUE(file);
    auto scene = formats::readUsdAnimation(std::move(*file), {"", "", 1e-5, /*edgeFactor=*/0});
    EXPECT_TRUE(scene) << scene.error().text();
    EXPECT_EQ(scene->lengthUnit, "mm");
    EXPECT_EQ(scene->up, "z");
    EXPECT_EQ(scene->bodies.at(0).name, "a torus");
    EXPECT_EQ(scene->bodies[0].mesh.triangles, fixtures::torus(3, 1, 9, 5).triangles);
    EXPECT_TRUE(scene->losses.empty());
    return std::move(*scene);
  }

  /// The largest distance of a vertex at a key from that of the light slice at its time.
  double farthest(const formats::AnimatedScene& scene) {
    const model::VertexKeys& run = *scene.bodies[0].runs.at(0);
    std::vector<model::Point3> found(scene.bodies[0].mesh.vertices.size());
    double most = 0;
    for (std::uint64_t key = 0; key < run.count(); ++key) {
      const auto light = slice::LightSlicer(mesh_).at(run.time(key));
      EXPECT_TRUE(light && run.positions(key, found));
      for (std::size_t i = 0; i < found.size(); ++i) {
        most = std::max(most, (found[i] - light->slice.mesh.vertices[i]).norm());
      }
    }
    return most;
  }

  std::filesystem::path path(const std::string& name) const { return folder_ / name; }
  std::string text(const std::string& name) const { return system::contents(path(name)); }

  model::Mesh mesh_ = turnedTorus();
  model::Body body_{"a torus", &mesh_};
  system::TestFolder folder_;
};

/// Coordinates up to 10 as float32.
constexpr double kRoundedBy = 1e-6;

TEST_F(UsdFlipbook, IsTheLightSliceAtEachFrame) {
  for (const char* name : {"out.usda", "out.usdz"}) {
    const formats::AnimatedScene scene = playedBy(writeFlipbook, name);
    EXPECT_EQ(scene.bodies[0].runs[0]->count(), 9U);
    EXPECT_LE(farthest(scene), kRoundedBy);
  }
  EXPECT_NE(text("out.usda").find("int[] faceVertexIndices = ["), std::string::npos);
}

TEST_F(UsdFlipbook, WithShapesAtLayersIsTheLightSliceAtAnyTime) {
  const formats::AnimatedScene scene = playedBy(writeMorphFlipbook);
  EXPECT_EQ(scene.bodies[0].runs[0]->count(), 5U) << "layers alone: points move straight between";
  EXPECT_LE(farthest(scene), kRoundedBy);
}

TEST_F(UsdFlipbook, OfARigidBodyTurnsIt) {
  const formats::AnimatedScene scene = playedBy(writeRigidFlipbook);
  EXPECT_TRUE(scene.bodies[0].runs[0]->pose(0));
  EXPECT_EQ(text("out.usda").find("points.timeSamples"), std::string::npos);
  const auto motion = rigidMotionOf(mesh_);
  ASSERT_TRUE(motion);
  EXPECT_LE(farthest(scene), motion->distance + kRoundedBy);
  // At the layers exactly.
  const model::VertexKeys& run = *scene.bodies[0].runs[0];
  std::vector<model::Point3> found(scene.bodies[0].mesh.vertices.size());
  std::size_t layers = 0;
  for (std::uint64_t key = 0; key < run.count(); ++key) {
    for (const RigidMotion::Layer& layer : motion->layers) {
      if (std::abs(layer.time - run.time(key)) > 1e-12) continue;
      ++layers;
      ASSERT_TRUE(run.positions(key, found));
      for (std::size_t i = 0; i < found.size(); ++i) {
        const auto exact = model::posed(layer.pose, motion->solid.vertices[i]);
        EXPECT_LE((found[i] - exact).norm(), kRoundedBy);
      }
    }
  }
  EXPECT_EQ(layers, 5U);
}

TEST_F(UsdFlipbook, OfExactSlicesHasTheFacesOfEach) {
  FlipbookOptions options;
  options.detail = slice::SliceDetail::Exact;
  const auto report = writeFlipbook({&body_, 1}, std::vector{0.1, 0.25}, path("e.usda"), options);
  ASSERT_TRUE(report) << report.error().text();
  auto file = formats::readInputFile(path("e.usda"));
  const auto scene = formats::readUsdAnimation(std::move(*file), {});
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message.find("change at time code 1"), std::string::npos);
  // At rest it is as at first.
  const auto loaded = formats::readTriangleMesh(path("e.usda"));
  ASSERT_TRUE(loaded) << loaded.error().text();
  const auto exact = slice::sliceAtTime(mesh_, 0.1);
  EXPECT_NEAR(signedVolume(loaded->mesh), signedVolume(exact->mesh), 1e-4);
}

TEST_F(UsdFlipbook, InFramesIsAValueClipSet) {
  const auto names = frameNames(path("frames").string(), ".usda");
  ASSERT_TRUE(names) << names.error().text();
  const auto report = writeFrameFiles({&body_, 1}, std::vector{0.0, 0.5, 1.0}, *names);
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_EQ(report->frames, 3U);
  const std::string root = text("frames/frames.usda");
  for (const char* part :
       {"asset[] assetPaths = [@@@./frame_0000.usda@@@, @@@./frame_0001.usda@@@, ",
        "double2[] active = [(0, 0), (1, 1), (2, 2)]",
        "asset manifestAssetPath = @@@./frames.usda@@@", "displayName = \"a torus\"",
        "        point3f[] points\n", "endTimeCode = 2\n"}) {
    EXPECT_NE(root.find(part), root.npos) << part << root;
  }
  const auto frame = formats::readTriangleMesh(path("frames/frame_0001.usda"));
  ASSERT_TRUE(frame) << frame.error().text();
  const auto exact = slice::sliceAtTime(mesh_, 0.5);
  EXPECT_NEAR(signedVolume(frame->mesh), signedVolume(exact->mesh), 1e-4);
  // It replaces its own files, and no others.
  EXPECT_TRUE(writeFrameFiles({&body_, 1}, std::vector{0.0, 0.5, 1.0}, *names));
  std::ofstream(path("frames/frames.usda")) << "#usda 1.0\n";
  EXPECT_FALSE(writeFrameFiles({&body_, 1}, std::vector{0.0, 0.5, 1.0}, *names));
}

TEST_F(UsdFlipbook, HasVelocities) {
  FlipbookOptions options;
  options.velocity = FrameVelocity{};
  options.velocity->timeUnits = {0.5, 0.5};
  const auto report = writeFlipbook({&body_, 1}, std::vector{0.1, 0.6}, path("v.usda"), options);
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_NE(text("v.usda").find("vector3f[] velocities.timeSamples = {"), std::string::npos);
  EXPECT_EQ(text("v.usda").find("primvars:velocity"), std::string::npos);
}

}  // namespace
}  // namespace t4d::convert
