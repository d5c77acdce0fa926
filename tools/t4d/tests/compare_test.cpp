#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tools/t4d/tests/box.h"
#include "tools/t4d/tests/program.h"

/// `t4d compare`.
namespace t4d::tools {
namespace {

TEST_F(Program, CompareTakesNamesThatLookLikeOptions) {
  fs::copy_file(folder_ / "fx" / "cube.obj", folder_ / "-c.obj");
  EXPECT_EQ(run("compare -m fx/rest.json --voxel-size 4 --frames 2 --slices 2 -- -c.obj").exitCode,
            0);
}

TEST_F(Program, ComparesBothBackendsOnOneSolid) {
  const std::string both =
      "compare fx/paper-cube.obj -m fx/paper-translation.json --voxel-size 2.5 --frames 9 ";
  const Finished done = run(both + "--slices 3 --keep kept --html page.html --json");
  ASSERT_EQ(done.exitCode, 0) << done.err;
  const json value = done.value();
  EXPECT_EQ(value["a"]["backend"], "mesh4d");
  EXPECT_EQ(value["b"]["backend"], "voxel4d");
  EXPECT_EQ(value["a"]["vertices"], 4750);
  EXPECT_EQ(value["a"]["tetrahedra"], 21552);
  for (const char* mesh : {"a", "b"}) {
    for (const char* key : {"bytes", "seconds", "peak_bytes", "hypervolume"}) {
      EXPECT_GT(value[mesh][key].get<double>(), 0) << mesh << " " << key;
    }
    EXPECT_NEAR(value[mesh]["hypervolume_expected"].get<double>(), 512000, 1e-6);
  }
  EXPECT_NEAR(value["a"]["hypervolume_error"].get<double>(), 0, 1e-12);
  EXPECT_LT(value["b"]["hypervolume_error"].get<double>(), 0);
  ASSERT_EQ(value["slices"].size(), 3U);
  for (const json& slice : value["slices"]) {
    // At these times the cube's faces lie on the lattice: only edges and corners are cut off.
    const double lost = slice["volume_a"].get<double>() - slice["volume_b"].get<double>();
    EXPECT_NEAR(slice["volume_a"].get<double>(), 8000, 1e-9);
    EXPECT_GT(lost, 0);
    EXPECT_NEAR(slice["symmetric_difference"].get<double>(), lost, 1e-3 * lost);
    EXPECT_GT(slice["area_a"], slice["area_b"]);
    EXPECT_LT(slice["hausdorff"].get<double>(), 2.5 * std::sqrt(3));
    EXPECT_LT(slice["hausdorff_95"], slice["hausdorff"]);
    EXPECT_LT(slice["mean_distance"], slice["hausdorff_95"]);
    EXPECT_NEAR(slice["volume_difference"].get<double>(), -lost, 1e-9);
    // b is within a.
    EXPECT_NEAR(slice["jaccard"].get<double>(), 1 - lost / 8000, 1e-3 * lost / 8000);
  }
  EXPECT_EQ(value["slices"][2]["time"], 64);

  const std::string page = contents(folder_ / "page.html");
  EXPECT_NE(page.find("<svg"), std::string::npos);
  EXPECT_NE(page.find("data:image/png;base64,iVBOR"), std::string::npos);
  for (const char* outside : {"http:", "https:", "<script", "<link"}) {
    EXPECT_EQ(page.find(outside), std::string::npos) << outside;
  }

  // The same two meshes as files: the same slices, and nothing about how they were made.
  const json files = run("compare kept/paper-cube-mesh4d.t4d kept/paper-cube-voxel4d.t4d "
                         "--times 0:64:3 --json")
                         .value();
  EXPECT_EQ(files["slices"], value["slices"]);
  EXPECT_EQ(files["b"]["tetrahedra"], value["b"]["tetrahedra"]);
  EXPECT_TRUE(files["a"]["seconds"].is_null() && files["b"]["peak_bytes"].is_null());
}

TEST_F(Program, ComparingWithItselfFindsNothing) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  const json value = run("compare cube.t4d cube.t4d --json").value();
  ASSERT_EQ(value["slices"].size(), 9U);
  for (const json& slice : value["slices"]) {
    EXPECT_EQ(slice["symmetric_difference"], 0);
    EXPECT_EQ(slice["hausdorff"], 0);
  }
  EXPECT_NE(run("compare cube.t4d cube.t4d").out.find("4,750"), std::string::npos);
}

TEST_F(Program, CompareSaysWhatIsWrong) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  EXPECT_EQ(run("compare cube.t4d").exitCode, 2);
  EXPECT_EQ(run("compare cube.t4d cube.t4d --frames 3").exitCode, 2);
  EXPECT_EQ(run("compare cube.t4d cube.t4d --times 0:1:0").exitCode, 2);
  refuses("compare cube.t4d cube.t4d --times 60:70:2", "last from 0 to 64");
  refuses("compare cube.t4d fx/cube.obj", "fx/cube.obj");
  const std::string rest = " --voxel-size 1 --frames 9 --html out.html";
  refuses("compare fx/cube.obj -m nothing.json" + rest, "nothing.json");
  refuses("compare fx/nothing.obj -m fx/rest.json" + rest, "nothing.obj");
  misused("compare fx/cube.obj -m fx/rest.json --voxel-size 1 --frames 1",
          "--frames: '1' is not a whole number from 2 to 1000000");
}

TEST_F(Program, CompareConvertsUnits) {
  // The same cube and motion in mm and s, in m and min, and in unknown units.
  const auto make = [&](const std::string& name, const char* length, const char* time, double side,
                        double duration) {
    write(name + ".obj", boxText({0, 0, 0}, {side, side, side}));
    write(name + ".json", fmt::format(R"({{"length_unit": "{}", "time_unit": "{}", "segments": [)"
                                      R"({{"duration": {}, "translation": [{}, 0, 0]}}]}})",
                                      length, time, duration, side));
    ASSERT_EQ(run("sweep " + name + ".obj -m " + name + ".json -o " + name + ".t4d").exitCode, 0);
  };
  make("small", "mm", "s", 500, 90);
  make("large", "m", "min", 0.5, 1.5);
  make("odd", "cubit", "s", 1, 90);
  const Finished done = run("compare small.t4d large.t4d --slices 4 --json --html page.html");
  ASSERT_EQ(done.exitCode, 0) << done.err;
  EXPECT_THAT(done.err, testing::HasSubstr("lengths of large.t4d are converted from m to mm"));
  EXPECT_THAT(done.err, testing::HasSubstr("times of large.t4d are converted from min to s"));
  const json value = done.value();
  EXPECT_EQ(value["length_unit"], "mm");
  EXPECT_EQ(value["time_unit"], "s");
  EXPECT_NEAR(value["b"]["hypervolume"].get<double>(), 1.25e8 * 90, 1);
  ASSERT_EQ(value["slices"].size(), 4U);
  for (const json& slice : value["slices"]) {
    EXPECT_NEAR(slice["volume_b"].get<double>(), 1.25e8, 1e-4);
    EXPECT_NEAR(slice["area_b"].get<double>(), 1.5e6, 1e-6);
    EXPECT_NEAR(slice["symmetric_difference"].get<double>(), 0, 1e-3);
    EXPECT_NEAR(slice["hausdorff"].get<double>(), 0, 1e-9);
  }
  EXPECT_THAT(contents(folder_ / "page.html"), testing::HasSubstr("[mm³]"));
  const json back = run("compare large.t4d small.t4d --slices 4 --json").value();
  EXPECT_EQ(back["length_unit"], "m");
  EXPECT_NEAR(back["b"]["hypervolume"].get<double>(), 0.125 * 1.5, 1e-12);
  refuses("compare small.t4d odd.t4d", "its length unit is 'cubit' and that of small.t4d is 'mm'");
  EXPECT_EQ(run("compare odd.t4d odd.t4d --slices 1").exitCode, 0);
  ASSERT_EQ(run(kPaper).exitCode, 0);
  EXPECT_THAT(run("compare small.t4d cube.t4d --times 0:1:2").err,
              testing::HasSubstr("only small.t4d states a length unit, mm"));
}

TEST_F(Program, CompareShowsTheConvergence) {
  const Finished done =
      run("compare fx/icosphere.obj -m fx/paper-translation.json --voxel-size 4,2 --voxel-size 8 "
          "--slices 2 --keep kept --csv all.csv --html page.html --json");
  ASSERT_EQ(done.exitCode, 0) << done.err;
  const json value = done.value();
  EXPECT_EQ(value["b"]["voxel_size"], 2);
  const json& levels = value["convergence"]["levels"];
  ASSERT_EQ(levels.size(), 3U);
  EXPECT_EQ(levels[0]["voxel_size"], 8);
  EXPECT_EQ(levels[1]["frames"], 17);
  EXPECT_GT(levels[1]["symmetric_difference"], levels[2]["symmetric_difference"]);
  EXPECT_GT(value["convergence"]["order_symmetric_difference"].get<double>(), 1);
  EXPECT_TRUE(fs::exists(folder_ / "kept" / "icosphere-voxel4d-4.t4d"));
  const std::string csv = contents(folder_ / "all.csv");
  EXPECT_EQ(csv.substr(0, csv.find('\n')),
            "voxel_size,frames,time,volume_a,volume_b,area_a,area_b,symmetric_difference,hausdorff,"
            "hausdorff_95,mean_distance,volume_difference,dice,jaccard");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 3 * 2);
  EXPECT_THAT(contents(folder_ / "page.html"), testing::HasSubstr("order of convergence"));
}

TEST_F(Program, CompareSaysWhenTimesFallOnFrames) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  EXPECT_THAT(run("compare cube.t4d cube.t4d --slices 9").err,
              testing::HasSubstr("all comparison times are layers of a and layers of b"));
  EXPECT_EQ(run("compare cube.t4d cube.t4d --slices 10").err, "");
}

TEST_F(Program, CompareTakesTimesThatDoNotBeatWithSteps) {
  write("turn.json", R"({"segments": [{"duration": 1, "axis_direction": [0, 0, 1],
                                       "angle_degrees": 360}]})");
  ASSERT_EQ(run("sweep fx/cube.obj -m turn.json --steps 12 -o turn.t4d").exitCode, 0);
  const json slices = run("compare turn.t4d turn.t4d --json").value()["slices"];
  ASSERT_EQ(slices.size(), 9U);
  EXPECT_EQ(slices[0]["time"], 0);
  EXPECT_EQ(slices[8]["time"], 1);
  for (std::size_t i = 2; i < 8; ++i) {
    EXPECT_NEAR(slices[i]["volume_a"].get<double>(), slices[1]["volume_a"].get<double>(), 1e-6);
  }
}

}  // namespace
}  // namespace t4d::tools
