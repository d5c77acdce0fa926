#include "t4d/verbs/sweep.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "t4d/fixtures/solids.h"
#include "t4d/formats/test_files.h"
#include "t4d/formats/triangle/triangle_mesh_writer.h"
#include "t4d/measure/mesh_check.h"
#include "t4d/verbs/compare_methods.h"
#include "t4d/verbs/input.h"

/// What is swept by a call is what the files say: each kind of input has the hypervolume that is
/// known for it.
namespace t4d::verbs {
namespace {

using formats::temporaryPath;

constexpr double kSide = 2;
constexpr double kDuration = 3;

/// A cube in a file, moved by `shift`.
std::string cubeFile(const std::string& name, double shift = 0) {
  formats::NamedMesh body{"cube", fixtures::cube(kSide)};
  for (model::Point3& vertex : body.mesh.vertices) vertex.x() += shift;
  const std::string path = temporaryPath(name).string();
  EXPECT_TRUE(formats::writeTriangleMeshes(path, {&body, 1}));
  return path;
}

std::string slidingMotion() {
  return formats::writeFile("slide.json", R"({"segments": [{"duration": 3,
                                             "translation": [5, 0, 0]}]})")
      .string();
}

SweepOptions optionsFor(decltype(SweepOptions::what) what) {
  SweepOptions options{.what = std::move(what), .caps = mesh4d::CapMethod::Cone};
  options.output.path = temporaryPath("swept.t4d").string();
  return options;
}

double hypervolumeOf(const std::string& path) {
  const auto input = openInput(path);
  EXPECT_TRUE(input) << input.error().text();
  double sum = 0;
  for (const model::Body& body : input->bodies) {
    const auto report = measure::checkMesh(*body.source);
    EXPECT_TRUE(report && report->valid());
    sum += report->hypervolume;
  }
  return sum;
}

/// The error of a sweep that must not succeed.
Error refusal(const SweepOptions& options) {
  const auto report = sweep(options);
  EXPECT_FALSE(report);
  return report ? Error{} : report.error();
}

class Notes : public Observer {
 public:
  void note(const std::string& notice) override { all.push_back(notice); }
  std::vector<std::string> all;
};

TEST(SweepFiles, AMotionSweepsTheVolumeForItsDuration) {
  const auto options = optionsFor(MotionSweep{cubeFile("cube.obj"), slidingMotion()});
  const auto report = sweep(options);
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_NEAR(hypervolumeOf(options.output.path), kSide * kSide * kSide * kDuration, 1e-9);
  EXPECT_EQ(report->steps, 1U);
  EXPECT_NEAR(report->chordBound.value_or(1), 0, 1e-12);
  EXPECT_FALSE(report->folds);
  EXPECT_TRUE(report->bodies.empty());
  const auto json = nlohmann::json::parse(jsonOf(*report, 7));
  EXPECT_EQ(json["tetrahedra"], report->tetrahedra);
  EXPECT_EQ(json["peak_bytes"], 7);
  EXPECT_FALSE(json.contains("folds"));
}

TEST(SweepFiles, KeysOneApartAreNoted) {
  const auto options =
      optionsFor(DeformationSweep{{cubeFile("cube_0.obj"), cubeFile("cube_1.obj", 1)}});
  Notes notes;
  const auto report = sweep(options, notes);
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_THAT(notes.all, testing::Contains(testing::HasSubstr("taken to be 1 apart")));
  EXPECT_NEAR(hypervolumeOf(options.output.path), kSide * kSide * kSide, 1e-9);
  ASSERT_TRUE(report->folds);
  EXPECT_EQ(report->folds->prisms, 0U);
  EXPECT_TRUE(nlohmann::json::parse(jsonOf(*report, 0)).contains("crossings"));
}

TEST(SweepFiles, EachSolidOfAMechanismIsABody) {
  const auto file = formats::writeFile("machine.json", R"({
    "length_unit": "mm", "time_unit": "s", "bodies": [
      {"name": "base", "solid": {"box": [2, 2, 2]}},
      {"name": "slide", "solid": {"box": [2, 2, 2]},
       "joint": {"type": "prismatic", "axis": [1, 0, 0]},
       "motion": {"times": [0, 3], "values": [0, 5]}}]})");
  EXPECT_EQ(sweepKindOf(std::vector{file.string()}, ""), SweepKind::Mechanism);
  auto options = optionsFor(MechanismSweep{file.string()});
  const auto report = sweep(options);
  ASSERT_TRUE(report) << report.error().text();
  ASSERT_EQ(report->bodies.size(), 2U);
  EXPECT_EQ(report->bodies[1].name, "slide");
  EXPECT_NEAR(hypervolumeOf(options.output.path), 2 * kSide * kSide * kSide * kDuration, 1e-9);
  options.output.body = "one name";
  EXPECT_EQ(refusal(options).code, ErrorCode::Options);
}

TEST(SweepFiles, TheVoxelMethodNotesWhatItIgnores) {
  MotionSweep what{cubeFile("cube.obj"), slidingMotion()};
  what.voxels = VoxelMethod{.voxelSize = 0.25, .ignored = {"steps"}};
  const auto report = sweep(optionsFor(what));
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_THAT(report->notices, testing::Contains("voxel4d ignores steps"));
  EXPECT_FALSE(report->chordBound);
}

TEST(SweepFiles, NoInputIsOverwritten) {
  const std::string cube = cubeFile("cube.obj");
  const std::string before = system::contents(cube);
  auto options = optionsFor(MotionSweep{cube, slidingMotion()});
  options.output.path = cube;
  EXPECT_EQ(refusal(options).code, ErrorCode::Options);
  EXPECT_EQ(system::contents(cube), before);
}

TEST(SweepFiles, ContradictionsAreRefused) {
  const MotionSweep moved{cubeFile("cube.obj"), slidingMotion()};
  auto options = optionsFor(moved);
  options.part = {1, 2};
  options.output.center = true;
  EXPECT_THAT(refusal(options).message, testing::HasSubstr("cannot be centred"));
  options = optionsFor(MechanismSweep{"machine.json"});
  options.part = {1, 2};
  EXPECT_THAT(refusal(options).message, testing::HasSubstr("of one body"));
  options = optionsFor(DeformationSweep{{"a.obj", "b.obj"}});
  options.mending = edit::MendSurfaceOptions{.maxMove = 1};
  EXPECT_THAT(refusal(options).message, testing::HasSubstr("moves no vertex"));
  EXPECT_THAT(refusal(optionsFor(DeformationSweep{})).message, testing::HasSubstr("no file"));
}

TEST(CompareMethods, ErrorsShrinkWithTheVoxels) {
  MethodsOptions options{cubeFile("cube.obj"), slidingMotion()};
  options.meshCaps = mesh4d::CapMethod::Cone;
  options.voxelSizes = {0.25, 0.5};
  const auto report = compareMethods(options, {.slices = 3}, makeHere(nobody()));
  ASSERT_TRUE(report) << report.error().text();
  const auto& all = report->compared.comparisons;
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].b.voxelSize, 0.5);
  EXPECT_NEAR(all[0].a.hypervolumeError().value_or(1), 0, 1e-12);
  EXPECT_LT(*all[1].meanDifference(), *all[0].meanDifference());
  EXPECT_FALSE(all[0].a.peakBytes);
  EXPECT_GT(all[0].a.seconds.value_or(0), 0);
}

}  // namespace
}  // namespace t4d::verbs
