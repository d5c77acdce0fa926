#include <filesystem>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "platform/test_folder.h"
#include "tools/t4d/envelope.h"
#include "tools/t4d/filter.h"
#include "tools/t4d/measure.h"
#include "tools/t4d/members.h"
#include "tools/t4d/resolve.h"
#include "tools/t4d/test_moving_cube.h"
#include "tools/t4d/transform.h"

/// Verbs that make something else of meshes in memory.
namespace t4d::tools {
namespace {

using nlohmann::json;

TEST(Envelope, OfACubeThatMovesAlongAnEdgeIsABox) {
  const model::Mesh mesh = movingCube(0, 4);
  const auto report = envelope(inMemory("cube", mesh));
  ASSERT_TRUE(report) << report.error().text();
  ASSERT_EQ(report->passages.all.size(), 1);
  const Passage& passage = report->passages.all[0];
  EXPECT_NEAR(passage.envelope.volume, 5, 1e-9);
  EXPECT_NEAR(passage.silhouette.hypervolume, 4, 1e-12);
  EXPECT_TRUE(report->losses().empty());
  const json value = json::parse(reportText(*report));
  EXPECT_TRUE(value["bodies"][0]["file"].is_null());
  EXPECT_EQ(value["closed"], true);
}

TEST(Envelope, OfATimeWindowIsShorter) {
  const model::Mesh mesh = movingCube(0, 4);
  const auto report = envelope(inMemory("cube", mesh), {.window = {.from = 1, .to = 2}});
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_NEAR(report->passages.all[0].envelope.volume, 2, 1e-9);
}

TEST(Envelope, SaysByItsRemedyWhatElseMayHelp) {
  const model::Mesh mesh = movingCube(0, 4);
  const Input input = inMemory("cube", mesh);
  const auto coarse = envelope(input, {.voxelSize = 50});
  ASSERT_FALSE(coarse);
  EXPECT_EQ(coarse.error().remedy, Remedy::VoxelSizeOrExact);
  const auto large =
      envelope(input, {.voxelSize = 0.1, .memory = 1e3, .fields = {.dwell = "dwell.vdb"}});
  ASSERT_FALSE(large);
  EXPECT_EQ(large.error().remedy, Remedy::VoxelSizeOrParts);
}

TEST(Measure, FollowsACubeAndTakesAShareOfTheTimes) {
  const model::Mesh mesh = movingCube(0, 4);
  const auto report = measure(inMemory("cube", mesh), {{0, 1, 2, 3}, {2, 2}});
  ASSERT_TRUE(report) << report.error().text();
  ASSERT_EQ(report->samples.size(), 2);
  const double center = report->samples[0].centroid.x();
  EXPECT_NEAR(report->samples[0].volume, 1, 1e-12);
  EXPECT_NEAR(report->samples[1].centroid.x(), center + 1, 1e-12);
  EXPECT_EQ(json::parse(reportText(*report))["samples"][1]["time"], 3);
  EXPECT_TRUE(measuresCsv(*report).starts_with("time,volume,"));
  EXPECT_EQ(measure(inMemory("cube", mesh))->samples.size(), 60);
}

TEST(Resolve, LeavesWhatIsClearInMemory) {
  const model::Mesh near = movingCube(0, 4);
  const model::Mesh far = movingCube(20, 21);
  const auto report = resolve(inMemory("far", far), inMemory("near", near));
  ASSERT_TRUE(report) << report.error().text();
  ASSERT_EQ(report->bodies.size(), 1);
  EXPECT_FALSE(report->all.changed);
  EXPECT_FALSE(report->bytes);
  EXPECT_EQ(json::parse(reportText(*report))["bodies"][0]["name"], "near");
}

TEST(Transform, ScalesVolumesAndTimesAsItsFactors) {
  const platform::TestFolder folder;
  const std::string path = (folder / "scaled.t4d").string();
  const model::Mesh mesh = movingCube(0, 4);
  const auto report = transform(
      inMemory("cube", mesh),
      {.scale = {{-2, 3, 4}}, .timeScale = 2, .timeShift = 1, .output = path, .generator = "test"});
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_TRUE(report->map.mirrors());
  const auto scaled = openInput(path);
  ASSERT_TRUE(scaled);
  const auto measured = measure(*scaled, {{1, 9}});
  ASSERT_TRUE(measured) << measured.error().text();
  EXPECT_NEAR(measured->samples[0].volume, 24, 1e-12);
  EXPECT_NEAR(measured->samples[1].centroid.x(), measured->samples[0].centroid.x() - 8, 1e-12);
}

TEST(Filter, KeepsTheSolidWithinTheSpan) {
  const platform::TestFolder folder;
  const std::string path = (folder / "part.t4d").string();
  const model::Mesh mesh = movingCube(0, 4);
  const auto report = filter(inMemory("cube", mesh), {{.from = 1, .to = 3}, {}, path, 3, "test"});
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_EQ(report->slabsCut, 2);
  EXPECT_EQ(report->caps.size(), 2);
  const auto part = openInput(path);
  ASSERT_TRUE(part);
  const auto passed = envelope(*part);
  ASSERT_TRUE(passed) << passed.error().text();
  EXPECT_NEAR(passed->passages.all[0].silhouette.hypervolume, 2, 1e-12);
}

}  // namespace
}  // namespace t4d::tools
