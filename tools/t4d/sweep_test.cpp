#include "tools/t4d/sweep.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "fixtures/solids.h"
#include "formats/test_files.h"
#include "formats/text/base64.h"
#include "t4d/check.h"
#include "t4d/slice.h"
#include "t4d/surface.h"
#include "tools/t4d/compare_methods.h"
#include "tools/t4d/input.h"
#include "tools/t4d/members.h"

/// What is swept by a call is what the files say: each kind of input has the hypervolume that is
/// known for it.
namespace t4d::tools {
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
  const auto json = nlohmann::json::parse(reportText(*report));
  EXPECT_EQ(json["tetrahedra"], report->tetrahedra);
  EXPECT_GT(json["peak_bytes"], 1'000'000);
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
  EXPECT_TRUE(nlohmann::json::parse(reportText(*report)).contains("crossings"));
}

/// A cube that turns about its axis in 4 s beside another one of side `other` at rest.
std::string turningBeside(double other) {
  std::vector<float> numbers;
  for (const double half : {0.5, other / 2}) {
    for (int i = 0; i < 8; ++i) {
      for (const int bit : {1, 2, 4}) {
        numbers.push_back(static_cast<float>((i & bit) != 0 ? half : -half));
      }
    }
  }
  for (int key = 0; key <= 4; ++key) numbers.push_back(static_cast<float>(key));
  for (int key = 0; key <= 4; ++key) {
    const double half = key * std::numbers::pi / 4;
    for (const double number : {0.0, 0.0, std::sin(half), std::cos(half)}) {
      numbers.push_back(static_cast<float>(number));
    }
  }
  std::vector<std::uint8_t> bytes(4 * numbers.size());
  std::memcpy(bytes.data(), numbers.data(), bytes.size());
  constexpr std::array<std::array<std::uint8_t, 4>, 6> kSides = {
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  for (const auto& [a, b, c, d] : kSides) bytes.insert(bytes.end(), {a, b, c, a, c, d});
  const auto mesh = [](int positions) {
    return fmt::format(R"({{"primitives":[{{"attributes":{{"POSITION":{}}},"indices":4}}]}})",
                       positions);
  };
  const auto accessor = [](int offset, int count, const char* type, int kind = 5126) {
    return fmt::format(
        R"({{"bufferView":0,"byteOffset":{},"componentType":{},"count":{},"type":"{}"}})", offset,
        kind, count, type);
  };
  return formats::writeFile(
             "turning.gltf",
             fmt::format(
                 R"({{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0,1]}}],)"
                 R"("nodes":[{{"name":"turning","mesh":0}},{{"name":"resting","mesh":1}}],)"
                 R"("meshes":[{},{}],"accessors":[{},{},{},{},{}],)"
                 R"("animations":[{{"samplers":[{{"input":2,"output":3}}],)"
                 R"("channels":[{{"sampler":0,"target":{{"node":0,"path":"rotation"}}}}]}}],)"
                 R"("bufferViews":[{{"buffer":0,"byteLength":{}}}],)"
                 R"("buffers":[{{"byteLength":{},"uri":"data:application/octet-stream;base64,{}"}}]}})",
                 mesh(0), mesh(1), accessor(0, 8, "VEC3"), accessor(96, 8, "VEC3"),
                 accessor(192, 5, "SCALAR"), accessor(212, 5, "VEC4"),
                 accessor(292, 36, "SCALAR", 5121), bytes.size(), bytes.size(),
                 formats::base64(bytes)))
      .string();
}

TEST(SweepFiles, ABodyIsSweptToAThousandthOfItsOwnSizeWhateverIsBesideIt) {
  // Between layers a turn by theta keeps 1 - 2 s (1 - s) (1 - cos(theta)) of the volume.
  std::uint64_t stepsAlone = 0;
  for (const double other : {1.0, 1e3, 1e6}) {
    SCOPED_TRACE(other);
    const auto options = optionsFor(AnimationSweep{turningBeside(other)});
    const auto report = sweep(options);
    ASSERT_TRUE(report) << report.error().text();
    ASSERT_EQ(report->bodies.size(), 2U);
    EXPECT_NEAR(report->bodies[0].tolerance.value_or(0), std::sqrt(2) / 1000, 0.5e-3);
    EXPECT_NEAR(report->bodies[1].tolerance.value_or(0), other / 1000, 1e-6 * other);
    EXPECT_EQ(report->tolerance,
              std::max(report->bodies[0].tolerance, report->bodies[1].tolerance));
    const std::uint64_t steps = report->bodies[0].steps;
    if (stepsAlone == 0) stepsAlone = steps;
    EXPECT_EQ(steps, stepsAlone);
    EXPECT_EQ(nlohmann::json::parse(reportText(*report))["bodies"][1]["tolerance"],
              *report->bodies[1].tolerance);
    const auto input = openInput(options.output.path);
    ASSERT_TRUE(input);
    const slice::TimeSlicer slicer(*input->bodies[0].source);
    const double theta = 2 * std::numbers::pi / static_cast<double>(steps);
    for (const double s : {0.0, 0.25, 0.5}) {
      const auto slice = slicer.at(4 * (3 + s) / static_cast<double>(steps));
      ASSERT_TRUE(slice);
      const double law = 1 - 2 * s * (1 - s) * (1 - std::cos(theta));
      EXPECT_NEAR(model::signedVolume(slice->mesh), law, 1e-6);
      EXPECT_GT(law, 0.99);
    }
  }
}

TEST(SweepFiles, ABodyThatRestsOrOnlyMovesFoldsNowhereThoughItHasSlivers) {
  // A box whose upper side has corners that are off an edge by the rounding of coordinates.
  const auto sliver = formats::writeFile(
      "sliver.obj",
      "v 1.7 2.3 0.0\nv 2.655336489125606 2.595520206661339 0.0\n"
      "v 2.3598162824642666 3.5508566957869454 0.0\nv 1.4044797933386604 3.2553364891256056 0.0\n"
      "v 1.7 2.3 1.1\nv 2.655336489125606 2.595520206661339 1.1\n"
      "v 2.3598162824642666 3.5508566957869454 1.1\nv 1.4044797933386604 3.2553364891256056 1.1\n"
      "v 2.018445496375202 2.39850673555378 1.1\nv 2.336890992750404 2.4970134711075596 1.1\n"
      "f 1 3 2\nf 1 4 3\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\nf 3 8 7\nf 4 1 5\n"
      "f 4 5 8\nf 5 6 10\nf 5 10 9\nf 6 7 10\nf 10 7 8\nf 10 8 9\nf 8 5 9\n");
  const auto file = formats::writeFile("slivers.json", fmt::format(R"({{
    "length_unit": "m", "time_unit": "s", "angle_unit": "deg", "bodies": [
      {{"name": "resting", "solid": "{0}"}},
      {{"name": "sliding", "solid": "{0}",
       "joint": {{"type": "prismatic", "axis": [1, 0.3, 0]}},
       "motion": {{"times": [0, 1], "values": [0, 1000]}}}},
      {{"name": "turning", "solid": "{0}",
       "joint": {{"type": "revolute", "axis": [0, 0.6, 0.8]}},
       "motion": {{"times": [0, 1], "values": [0, 90]}}}}]}})",
                                                                   sliver.filename().string()));
  const auto report = sweep(optionsFor(MechanismSweep{file.string()}));
  ASSERT_TRUE(report) << report.error().text();
  ASSERT_TRUE(report->folds);
  EXPECT_EQ(report->folds->prisms, 0U);
  EXPECT_THAT(report->notices, testing::Not(testing::Contains(testing::HasSubstr("fold"))));
}

TEST(SweepFiles, ALinkFarFromItsAxisIsRefusedSoonOrBoundedAsAsked) {
  const auto machine = [](double x) {
    return formats::writeFile("far.json", fmt::format(R"({{
      "length_unit": "m", "time_unit": "s", "angle_unit": "deg", "bodies": [
        {{"name": "arm", "solid": {{"box": [1, 1, 1]}},
         "joint": {{"type": "revolute", "axis": [0, 0, 1], "origin": [{}, 0, 0]}},
         "motion": {{"times": [0, 1], "values": [0, 90]}}}}]}})",
                                                      x))
        .string();
  };
  MechanismSweep what{.file = machine(1e14), .steps = mesh4d::MaxDeviation{0.01}};
  EXPECT_THAT(refusal(optionsFor(what)).message,
              testing::HasSubstr("steps or more, at most 100002"));
  what.file = machine(1e7);
  what.maxSteps = 1000;
  EXPECT_THAT(refusal(optionsFor(what)).message, testing::HasSubstr("at most 1000 "));
  what.maxSteps = 40'000;
  Notes notes;
  const auto report = sweep(optionsFor(what), notes);
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_THAT(notes.all, testing::Contains(
                             testing::HasSubstr(fmt::format("'arm' has {} steps", report->steps))));
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
  const std::string before = platform::contents(cube);
  auto options = optionsFor(MotionSweep{cube, slidingMotion()});
  options.output.path = cube;
  EXPECT_EQ(refusal(options).code, ErrorCode::Options);
  EXPECT_EQ(platform::contents(cube), before);
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
}  // namespace t4d::tools
