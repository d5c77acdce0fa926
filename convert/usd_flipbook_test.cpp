#include <fstream>

#include <gtest/gtest.h>

#include "convert/frame_files.h"
#include "fixtures/solids.h"
#include "platform/test_folder.h"
#include "t4d/convert.h"
#include "t4d/sweep.h"

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
  std::filesystem::path path(const std::string& name) const { return folder_ / name; }
  std::string text(const std::string& name) const { return platform::contents(path(name)); }

  model::Mesh mesh_ = turnedTorus();
  model::Body body_{"a torus", &mesh_};
  platform::TestFolder folder_;
};

TEST_F(UsdFlipbook, OfARigidBodyTurnsIt) {
  const auto report =
      writeRigidFlipbook({&body_, 1}, model::evenTimes({0, 1}, 9), path("r.usda"), {}, {});
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_EQ(text("r.usda").find("points.timeSamples"), std::string::npos);
  EXPECT_NE(text("r.usda").find("quatd xformOp:orient.timeSamples"), std::string::npos);
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
