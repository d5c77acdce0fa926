#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "formats/t4d/body_details.h"
#include "mesh4d/mechanism_keys.h"
#include "t4d/sweep.h"
#include "tools/t4d/collide.h"
#include "tools/t4d/members.h"
#include "tools/t4d/quality.h"
#include "tools/t4d/test_moving_cube.h"

/// Verbs that ask a question of meshes in memory, which no file holds.
namespace t4d::tools {
namespace {

using nlohmann::json;

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
  const json value = json::parse(reportText(*report));
  EXPECT_EQ(value["worst"].size(), 3);
  EXPECT_EQ(value["worst"][0]["body"], "cube");
  EXPECT_TRUE(value["bytes"].is_null());
}

TEST(Quality, RefusesAScaleThatFlattensAllCellsAndAnUnknownMeasure) {
  const model::Mesh mesh = movingCube(0, 4);
  const auto flat = quality(inMemory("cube", mesh), {.timeScale = 1e300});
  ASSERT_FALSE(flat);
  EXPECT_EQ(flat.error().code, ErrorCode::Options);
  EXPECT_EQ(flat.error().where.text(), "cube");
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
  const json pair = json::parse(reportText(*report))["pairs"][0];
  EXPECT_EQ(pair["a"], "right");
  EXPECT_EQ(pair["verdict"], "hit");
}

TEST(Collide, SamplesTheClearanceOfTheClosedForm) {
  const model::Mesh right = movingCube(0, 4);
  const model::Mesh left = movingCube(5, 1);
  const Input inputs[] = {inMemory("right", right), inMemory("left, \"odd\"", left)};
  const auto report = collide(inputs, {.times = {0.5, 1.5, 2.5}});
  ASSERT_TRUE(report) << report.error().text();
  const std::vector<measure::ClearanceSample>& samples = report->pairs[0].samples;
  ASSERT_EQ(samples.size(), 3);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(samples[i].distance, 4 - 2 * samples[i].time, 1e-12);
    EXPECT_NEAR(samples[i].lowerBound, samples[i].distance, 1e-9);
    EXPECT_EQ(samples[i].overlapDepth, 0);
  }
  // They overlap by 2 t - 4, and the deepest point is half of it inside.
  EXPECT_EQ(samples[2].distance, 0);
  EXPECT_LE(samples[2].overlapDepth, 0.5);
  EXPECT_GT(samples[2].overlapDepth, 0.48);
  const std::string csv = clearanceCsv(*report);
  EXPECT_TRUE(
      csv.starts_with("time,a,b,distance,lower_bound,overlap_depth\n0.5,right,"
                      "\"left, \"\"odd\"\"\","))
      << csv;
  EXPECT_EQ(json::parse(clearanceJson(*report))["pairs"][0]["samples"].size(), 3);
}

/// Faces in common, overlap only near the end of the contact, and plain overlap.
TEST(Collide, HasTheSameVerdictWithoutVolumes) {
  const model::Mesh right = movingCube(0, 4);
  const model::Mesh left = movingCube(5, 1);
  const model::Mesh same = movingCube(0, 4);
  const model::Mesh others[] = {left, same, movingCube(0.999, 4.999)};
  for (const model::Mesh& other : others) {
    const Input inputs[] = {inMemory("right", right), inMemory("other", other)};
    const auto with = collide(inputs);
    const auto without = collide(inputs, {.overlapVolumes = false});
    ASSERT_TRUE(with && without);
    EXPECT_EQ(without->pairs[0].verdict.verdict, with->pairs[0].verdict.verdict);
    EXPECT_EQ(with->pairs[0].verdict.verdict, measure::Verdict::Hit);
  }
}

TEST(Collide, LeavesOutPairs) {
  const model::Mesh arm = movingCube(0, 4);
  Input input = inMemory("base", arm);
  for (const char* name : {"link", "tool"}) {
    input.bodies.push_back({name, &arm});
    input.metadata.bodies.push_back({.name = name});
  }
  input.metadata.bodies[1].parent = "base";
  input.metadata.bodies[2].parent = "link";
  const auto tested = [&](const CollideOptions& options) {
    std::vector<std::string> pairs;
    const auto report = collide({&input, 1}, options);
    if (!report) return pairs;
    for (const CollidedPair& pair : report->pairs) pairs.push_back(pair.a.name + pair.b.name);
    const std::size_t count = input.bodies.size();
    EXPECT_EQ(report->pairs.size() + report->ignored.size(), count * (count - 1) / 2);
    return pairs;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(tested({}), Names{"basetool"});
  EXPECT_EQ(tested({.adjacent = true}), (Names{"baselink", "basetool", "linktool"}));
  EXPECT_EQ(tested({.ignore = {{"link", "base"}}, .adjacent = true}),
            (Names{"basetool", "linktool"}));
  // Several bodies of one link are joined, and so are those of its neighbours.
  input.bodies.push_back({"link 2", &arm});
  input.metadata.bodies.push_back({.name = "link 2", .parent = "link"});
  formats::setLink(input.metadata.bodies.back(), "link");
  EXPECT_EQ(tested({}), Names{"basetool"});
  EXPECT_EQ(tested({.ignore = {{"base", "link"}}, .adjacent = true}),
            (Names{"basetool", "baselink 2", "linktool", "linklink 2", "toollink 2"}));
  const auto none = collide({&input, 1}, {.ignore = {{"tool", "base"}}});
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, ErrorCode::Options);
}

/// A coupler that two cranks carry along half a circle of radius 10 without turning it, below a
/// beam that it just scrapes, by 0.01 for a moment.
Input parallelogram(const mesh4d::StepRule& rule, std::array<model::Mesh, 2>& meshes) {
  using model::Joint;
  const auto turning = [](double x, double degrees) {
    const Joint joint{Joint::Type::Revolute, {x, 0, 0}, {0, 0, 1}};
    return *model::jointMotion(joint, std::vector{0.0, 1.0}, std::vector{0.0, degrees});
  };
  model::Mechanism mechanism;
  mechanism.links = {
      {"crank", model::Link::kWorld, turning(0, 180)}, {"coupler", 0, turning(10, -180)}, {"beam"}};
  const model::TriangleMesh cube = fixtures::cube(1);
  const model::Point3 beam(0, 10 + 1 - 0.01, 0);
  const mesh4d::LinkSolid solids[] = {{&cube, 1, {Eigen::Matrix3d::Identity(), {10, 0, 0}}},
                                      {&cube, 2, {Eigen::Matrix3d::Identity(), beam}}};
  auto keys = mesh4d::mechanismKeys(mechanism, solids, rule, mesh4d::PrismSplit::Fourteen, true);
  EXPECT_TRUE(keys);
  Input input{.name = "parallelogram", .metadata = {}, .bodies = {}};
  for (std::size_t i = 0; i < 2; ++i) {
    const std::string name = mechanism.links[i + 1].name;
    EXPECT_TRUE(
        mesh4d::sweep(cube, *(*keys)[i].keys, {.caps = mesh4d::CapMethod::Cone}, meshes[i]));
    input.bodies.push_back({name, &meshes[i]});
    input.metadata.bodies.push_back({.name = name});
    formats::setChordBound(input.metadata.bodies.back(), (*keys)[i].chordBound);
  }
  return input;
}

// Without turning it has the poses of a translation, which a mesh follows exactly.
TEST(Collide, TheMotionOfJointsIsNotTakenForTheScrewFromPoseToPose) {
  std::array<model::Mesh, 2> meshes;
  Input input = parallelogram(mesh4d::StepsPerSegment{5}, meshes);
  auto report = collide({&input, 1});
  ASSERT_TRUE(report);
  const measure::CollisionVerdict& verdict = report->pairs[0].verdict;
  EXPECT_FALSE(report->pairs[0].collision.contact());
  EXPECT_EQ(verdict.verdict, measure::Verdict::WithinTolerance);
  EXPECT_GE(*verdict.chordBound, 10 * (1 - std::cos(std::numbers::pi / 10)));
  EXPECT_FALSE(verdict.minVolumeRatio);
  // Each answer names the steps for the next.
  for (int k = 0; k < 6 && report->pairs[0].decidingDeviation(); ++k) {
    meshes = {};
    input = parallelogram(mesh4d::MaxDeviation{*report->pairs[0].decidingDeviation()}, meshes);
    report = collide({&input, 1});
    ASSERT_TRUE(report);
  }
  EXPECT_EQ(report->pairs[0].verdict.verdict, measure::Verdict::Hit);
}

TEST(Collide, AMergedFileKnowsOnlyWhatAllOfItsFilesKnow) {
  const model::Mesh mesh = movingCube(0, 4);
  Input input = inMemory("a", mesh);
  const auto known = [&](const char* details) {
    input.metadata.detailsJson = details;
    return motionOf(input, "a").isKnown;
  };
  EXPECT_TRUE(known(R"({"source":{"mesh":"a.obj","motion":"m.json"}})"));
  EXPECT_FALSE(known(R"({"source":{"mesh":"a.glb"}})"));
  EXPECT_TRUE(known(R"({"merged":[{"details":{"source":{"mechanism":"a.json"}}}]})"));
  EXPECT_FALSE(known(R"({"merged":[{"details":{}},{"details":{"source":{"mesh":"a.glb"}}}]})"));
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
}  // namespace t4d::tools
