#include <filesystem>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "platform/test_folder.h"
#include "t4d/surface.h"
#include "tools/t4d/flipbook.h"
#include "tools/t4d/frames.h"
#include "tools/t4d/members.h"
#include "tools/t4d/slice.h"
#include "tools/t4d/test_moving_cube.h"

/// Verbs that slice meshes in memory.
namespace t4d::tools {
namespace {

using nlohmann::json;

TEST(SliceMesh, AtATimeIsTheCubeInMemory) {
  const model::Mesh mesh = movingCube(0, 4);
  const auto report = sliceMesh(inMemory("cube", mesh), {.time = 1.25});
  ASSERT_TRUE(report) << report.error().text();
  ASSERT_EQ(report->sections.size(), 1);
  EXPECT_EQ(report->sections[0].name, "cube");
  EXPECT_EQ(report->sections[0].mesh.triangles.size(), report->triangles);
  EXPECT_TRUE(report->closed);
  EXPECT_NEAR(report->volume, 1, 1e-12);
  EXPECT_NEAR(report->area, 6, 1e-12);
  const json value = json::parse(reportText(*report));
  EXPECT_TRUE(value["max_speed"].is_null());
  EXPECT_EQ(value["bytes_read"], 0);
}

TEST(SliceMesh, AcrossTheMotionLastsAsLongAsTheCubeIsThere) {
  const model::Mesh mesh = movingCube(0, 4);
  const auto report =
      sliceMesh(inMemory("cube", mesh), {.hyperplane = slice::Hyperplane::across(0, 2)});
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_TRUE(report->closed);
  EXPECT_NEAR(report->volume, 1, 1e-12);  // an area of 1 for a time of 1
}

TEST(SliceMesh, MergesAndIsLightAsAsked) {
  const model::Mesh mesh = movingCube(0, 4);
  const Input input = inMemory("cube", mesh);
  const auto exact = sliceMesh(input, {.time = 1.25, .mergeCoplanar = true});
  const auto light = sliceMesh(input, {.time = 1.25, .light = true});
  ASSERT_TRUE(exact && light);
  EXPECT_EQ(exact->triangles, 12);
  EXPECT_GT(exact->merge->trianglesBefore, 12);
  EXPECT_EQ(light->triangles, 12);
  EXPECT_TRUE(light->light);
}

TEST(SliceMesh, ColoursBySpeedAndCentersTheFileAlone) {
  const platform::TestFolder folder;
  const std::string path = (folder / "cube.ply").string();
  const model::Mesh mesh = movingCube(0, 4);
  const auto report =
      sliceMesh(inMemory("cube", mesh),
                {.time = 3,
                 .write = {.color = "speed", .velocity = true, .maxSpeed = 10, .center = true},
                 .output = path});
  ASSERT_TRUE(report) << report.error().text();
  ASSERT_TRUE(report->velocity);
  EXPECT_NEAR(report->velocity->maxSpeed, 1, 1e-12);
  EXPECT_NEAR(report->velocity->volumeRate, 0, 1e-12);
  EXPECT_TRUE(report->velocity->ofPoints);
  EXPECT_EQ(report->colorRange->at(1), report->velocity->maxSpeed);
  const formats::NamedMesh& section = report->sections[0];
  EXPECT_TRUE(section.colors);
  ASSERT_EQ(section.mesh.attributes.size(), 1);
  EXPECT_EQ(section.mesh.attributes[0].name, slice::kVelocity);
  const auto read = formats::readTriangleMesh(path);
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_NEAR(model::boundsOf(section.mesh).max.x() - model::boundsOf(read->mesh).max.x(), 3, 0.5);
}

TEST(Flipbook, ShowsTheWholeTimeInEveryKind) {
  const platform::TestFolder folder;
  const model::Mesh mesh = movingCube(0, 4);
  const std::string path = (folder / "cube.glb").string();
  for (const FlipbookKind kind : {FlipbookKind::Frames, FlipbookKind::Rigid, FlipbookKind::Morph}) {
    const auto report = flipbook(inMemory("cube", mesh), {.output = path, .kind = kind});
    ASSERT_TRUE(report) << report.error().text();
    EXPECT_EQ(report->firstTime, 0);
    EXPECT_EQ(report->lastTime, 4);
    EXPECT_EQ(report->seconds, 2.5);  // 60 frames
    EXPECT_EQ(report->bytes, std::filesystem::file_size(path));
    const json value = json::parse(reportText(*report));
    EXPECT_EQ(value["files"], json({path}));
    EXPECT_EQ(value["rigid"], kind == FlipbookKind::Rigid);
  }
}

TEST(Flipbook, RefusesSpeedsOfOneFrame) {
  const model::Mesh mesh = movingCube(0, 4);
  const auto still = flipbook(inMemory("cube", mesh),
                              {.output = "a.usda", .times = {2}, .write = {.velocity = true}});
  ASSERT_FALSE(still);
  EXPECT_EQ(still.error().remedy, Remedy::MoreFrames);
}

TEST(Frames, OfAPartAreThoseOfTheWhole) {
  const platform::TestFolder folder;
  const auto names = convert::frameNames((folder / "out").string(), ".ply");
  ASSERT_TRUE(names);
  const model::Mesh mesh = movingCube(0, 4);
  const Input input = inMemory("cube", mesh);
  const auto report = frames(input, {.names = *names,
                                     .times = {0, 1, 2, 3, 4},
                                     .light = true,
                                     .part = {2, 2},
                                     .write = {.color = "time"}});
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_EQ(report->written.frames, 2);
  EXPECT_EQ(report->firstTime, 3);
  EXPECT_EQ(report->lastTime, 4);
  EXPECT_TRUE(std::filesystem::exists(report->manifest));
  EXPECT_TRUE(std::filesystem::exists(names->folder / "frame_0003.ply"));
  EXPECT_EQ(json::parse(reportText(*report))["triangles"], 24);
}

TEST(Frames, RefuseSpeedsInPlaybackOfOne) {
  const auto names = convert::frameNames("out", ".usda");
  ASSERT_TRUE(names);
  const model::Mesh mesh = movingCube(0, 4);
  const Input input = inMemory("cube", mesh);
  const auto still = frames(input, {.names = *names, .times = {1}, .write = {.velocity = true}});
  ASSERT_FALSE(still);
  EXPECT_EQ(still.error().remedy, Remedy::MoreFrames);
}

}  // namespace
}  // namespace t4d::tools
