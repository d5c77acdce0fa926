#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "t4d/fixtures/solids.h"
#include "t4d/formats/motion_reader.h"
#include "t4d/mesh4d/sweep.h"
#include "t4d/verbs/collide.h"
#include "t4d/verbs/quality.h"

/// Verbs that ask a question of meshes in memory, which no file holds.
namespace t4d::verbs {
namespace {

using nlohmann::json;

/// The unit cube that moves from one place to another along x, with speed 1.
model::Mesh movingCube(double from, double to) {
  model::TriangleMesh cube = fixtures::cube(1);
  for (model::Point3& vertex : cube.vertices) vertex.x() += from;
  const auto motion = formats::parseMotion(
      json{{"segments", {{{"duration", std::abs(to - from)}, {"translation", {to - from, 0, 0}}}}}}
          .dump(),
      "motion");
  EXPECT_TRUE(motion);
  model::Mesh mesh;
  EXPECT_TRUE(
      mesh4d::sweep(cube, *motion, {mesh4d::StepsPerSegment{2}, mesh4d::CapMethod::Cone}, mesh));
  return mesh;
}

Input inMemory(const std::string& name, const model::Mesh& mesh) {
  Input input{.name = name, .metadata = {}, .bodies = {{name, &mesh}}};
  input.metadata.bodies = {{name}};
  return input;
}

/// Counts what it sees.
class Counter : public Observer {
 public:
  std::unique_ptr<Stage> stage(std::string title, std::uint64_t total, std::string) override {
    titles.push_back(std::move(title));
    totals.push_back(total);
    return std::make_unique<Stage>();
  }
  std::vector<std::string> titles;
  std::vector<std::uint64_t> totals;
};

TEST(Quality, OfAMeshInMemoryTakesTheMeanNormalSpeedAsScale) {
  const model::Mesh mesh = movingCube(0, 4);
  Counter counter;
  const auto report = quality(inMemory("cube", mesh), {.worst = 3}, counter);
  ASSERT_TRUE(report) << report.error().text();
  // Two of the six faces move along their normal, with speed 1.
  EXPECT_NEAR(report->quality.timeScale, 1.0 / 3, 1e-12);
  EXPECT_EQ(counter.titles, (std::vector<std::string>{"measuring the speed", "measuring cells"}));
  EXPECT_EQ(counter.totals, std::vector<std::uint64_t>(2, mesh.slabCount()));
  const json value = json::parse(jsonOf(*report));
  EXPECT_EQ(value["worst"].size(), 3);
  EXPECT_EQ(value["worst"][0]["body"], "cube");
  EXPECT_TRUE(value["bytes"].is_null());
}

TEST(Quality, RefusesAScaleThatFlattensAllCellsAndAnUnknownMeasure) {
  const model::Mesh mesh = movingCube(0, 4);
  const auto flat = quality(inMemory("cube", mesh), {.timeScale = 1e300});
  ASSERT_FALSE(flat);
  EXPECT_EQ(flat.error().code, ErrorCode::Options);
  EXPECT_EQ(flat.error().where, "cube");
  const auto unknown =
      quality(inMemory("cube", mesh), {.output = "out.t4d", .attributes = {"roundness"}});
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().code, ErrorCode::Options);
}

TEST(Collide, CubesThatMeetHalfWayTouchAtTheTimeOfTheClosedForm) {
  const model::Mesh right = movingCube(0, 4);
  const model::Mesh left = movingCube(5, 1);
  const Input inputs[] = {inMemory("right", right), inMemory("left", left)};
  const auto report = collide(inputs);
  ASSERT_TRUE(report) << report.error().text();
  ASSERT_EQ(report->pairs.size(), 1);
  const measure::Collision& collision = report->pairs[0].collision;
  ASSERT_EQ(collision.intervals.size(), 1);
  EXPECT_NEAR(collision.intervals[0].begin, 2, 1e-12);  // 4 apart, 2 of speed
  EXPECT_NEAR(collision.intervals[0].end, 3, 1e-12);
  EXPECT_TRUE(report->mayMeet());
  const json pair = json::parse(jsonOf(*report))["pairs"][0];
  EXPECT_EQ(pair["a"], "right");
  EXPECT_EQ(pair["verdict"], "hit");
}

TEST(Collide, AsksForTheSameUnitsAndForTwoBodies) {
  const model::Mesh mesh = movingCube(0, 4);
  const model::Mesh other = movingCube(9, 8);
  Input inputs[] = {inMemory("a", mesh), inMemory("b", other)};
  inputs[1].metadata.lengthUnit = "mm";
  const auto differ = collide(inputs);
  ASSERT_FALSE(differ);
  EXPECT_EQ(differ.error().remedy, Remedy::Units);
  const auto ignored = collide(inputs, {.clearance = 3, .ignoreUnits = true});
  ASSERT_TRUE(ignored);
  EXPECT_TRUE(ignored->pairs[0].keepsClearance());
  const auto view = contactView(ignored->pairs[0]);
  ASSERT_TRUE(view && *view);
  EXPECT_EQ((*view)->contactA, std::vector<bool>((*view)->a.triangles.size(), false));
  EXPECT_FALSE(collide({inputs, 1}));
}

}  // namespace
}  // namespace t4d::verbs
