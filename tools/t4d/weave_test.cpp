#include "tools/t4d/weave.h"

#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "fixtures/solids.h"
#include "platform/test_folder.h"
#include "t4d/surface.h"
#include "tools/t4d/input.h"
#include "tools/t4d/members.h"
#include "voxel4d/frame_formats.h"
#include "voxel4d/sampled_frames.h"

namespace t4d::tools {
namespace {

using nlohmann::json;

/// A ball of radius 3 that moves along x, with speed 1.
WeaveInput movingBall() {
  const auto field = [](const model::Point3& point, double time) {
    return (point - model::Point3(time, 0, 0)).norm() - 3;
  };
  model::Bounds3 box;
  box.add({-5, -5, -5});
  box.add({7, 5, 5});
  WeaveInput input{.name = "ball", .frames = {}};
  input.frames.frames =
      voxel4d::sampledFrames(field, {.voxelSize = 0.5, .origin = {0, 0, 0}}, box, {0, 0.5, 1, 1.5});
  return input;
}

TEST(Weave, TakesFramesInMemory) {
  const platform::TestFolder folder;
  const std::string path = (folder / "ball.t4d").string();
  WeaveOptions options{.lengthUnit = "mm"};
  options.output.path = path;
  options.output.generator = "a test";
  const auto report = weave(movingBall(), options);
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_EQ(report->woven.frames, 4);
  EXPECT_EQ(report->framesInBetween, 0);
  EXPECT_FALSE(report->oneApart);
  EXPECT_TRUE(report->losses.empty());
  const auto input = openInput(path);
  ASSERT_TRUE(input) << input.error().text();
  EXPECT_EQ(input->metadata.lengthUnit, "mm");
  EXPECT_EQ(input->metadata.bodies.front().name, "ball");
  const json details = json::parse(input->metadata.detailsJson);
  EXPECT_EQ(details["source"], (json{{"frames", "ball"}}));
  EXPECT_EQ(details["parameters"]["caps"], "flat");
  EXPECT_EQ(input->reader->summary(0).tetrahedra, report->woven.tetrahedra);
  const json value = json::parse(reportText(*report));
  EXPECT_GT(value["peak_bytes"], 1'000'000);
  EXPECT_TRUE(value["space"].is_null());
  EXPECT_EQ(value["bytes"], std::filesystem::file_size(path));
}

TEST(OpenFrames, SaysOfAnotherFormatWhatIsRead) {
  const platform::TestFolder folder;
  const std::string path = (folder / "grid.xyz").string();
  std::ofstream(path) << "no grid at all";
  const auto input = openFrames({path}, {});
  ASSERT_FALSE(input);
  EXPECT_EQ(input.error().message,
            "is not a VDB file, and not a volume by its extension; expected .vdb, " +
                volumeExtensions() + ", or triangle meshes");
  EXPECT_EQ(input.error().where.text(), path);
}

TEST(OpenFrames, RefusesFramesThatAreNotOfOneKindAndMeshesWithoutAVoxelSize) {
  const auto kindOf = [](std::vector<std::string> files) { return frameKindOf(files); };
  EXPECT_EQ(*kindOf({"a.vdb", "b.vdb"}), FrameKind::Vdb);
  EXPECT_EQ(*kindOf({"a.nrrd"}), FrameKind::Volumes);
  EXPECT_EQ(*kindOf({"a.obj", "b.stl"}), FrameKind::Meshes);
  EXPECT_EQ(kindOf({"a.obj", "b.vdb"}).error().code, ErrorCode::Options);
  EXPECT_EQ(kindOf({}).error().code, ErrorCode::Options);
  EXPECT_EQ(openFrames({"a.obj", "b.obj"}, {}).error().code, ErrorCode::Options);
}

TEST(Weave, OfMeshesDoesNotWriteOverOneOfThem) {
  const platform::TestFolder folder;
  formats::NamedMesh cube;
  cube.mesh = fixtures::cube(4);
  std::vector<std::string> files;
  for (const char* name : {"a_0.obj", "a_1.obj"}) {
    files.push_back((folder / name).string());
    ASSERT_TRUE(formats::writeTriangleMeshes(files.back(), std::vector{cube}));
  }
  auto input = openFrames(files, {.voxelSize = 1.0});
  ASSERT_TRUE(input) << input.error().text();
  EXPECT_EQ(input->meshes->notices.size(), 1);
  const auto before = std::filesystem::file_size(files[1]);
  WeaveOptions options;
  options.output.path = files[1];
  const auto report = weave(std::move(*input), options);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().code, ErrorCode::Options);
  EXPECT_EQ(std::filesystem::file_size(files[1]), before);
}

}  // namespace
}  // namespace t4d::tools
