#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <sstream>
#include <string>

#include <gmock/gmock.h>

#include "tools/t4d/tests/box.h"
#include "tools/t4d/tests/program.h"

/// `t4d sweep` of a solid along a motion, and what other verbs make of it.
namespace t4d::tools {
namespace {

TEST_F(Program, PaperCubeEndToEnd) {
  const json swept = run(std::string(kPaper) + " --json").value();
  EXPECT_EQ(swept["vertices"], 4750);
  EXPECT_EQ(swept["tetrahedra"], 21552);
  EXPECT_EQ(swept["steps"], 64);
  EXPECT_EQ(swept["cap_tetrahedra"], json::array({24, 24}));
  EXPECT_TRUE(swept.contains("seconds") && swept.contains("peak_bytes"));

  const json info = run("info cube.t4d --json").value();
  EXPECT_EQ(info["format_version"], "1.0");
  EXPECT_EQ(info["backend"], "mesh4d");
  EXPECT_EQ(info["slabs"], 66);
  EXPECT_EQ(info["vertices"], 4750);
  EXPECT_EQ(info["tetrahedra"], 21552);
  EXPECT_EQ(info["time_begin"], 0);
  EXPECT_EQ(info["time_end"], 64);
  EXPECT_EQ(info["bounds_min"], json::array({-10, -10, -10}));
  EXPECT_EQ(info["bounds_max"], json::array({10, 10, 74}));
  EXPECT_EQ(info["bytes"], fs::file_size(folder_ / "cube.t4d"));
  for (const char* key : {"generator", "length_unit", "time_unit"}) {
    EXPECT_TRUE(info.contains(key));
  }

  const json valid = run("validate cube.t4d --deep --json").value();
  EXPECT_EQ(valid["valid"], true);
  EXPECT_EQ(valid["closed"], true);
  EXPECT_EQ(valid["oriented"], true);
  EXPECT_EQ(valid["vertex_links_ok"], true);
  EXPECT_EQ(valid["components"], 1);
  EXPECT_EQ(valid["degenerate_cells"], 0);
  EXPECT_NEAR(valid["hypervolume"].get<double>(), 512000, 512000 * 1e-9);
  EXPECT_EQ(valid["issues"]["errors"], 0);

  const json slice = run("slice cube.t4d --time 31.5 -o at.glb --json").value();
  EXPECT_EQ(slice["closed"], true);
  EXPECT_NEAR(slice["volume"].get<double>(), 8000, 8e-6);
  EXPECT_EQ(slice["slabs_read"], 1);
  EXPECT_LT(slice["bytes_read"].get<double>(), info["bytes"].get<double>() / 2);
  const json layer = run("slice cube.t4d --time 64 -o at.ply --json").value();
  EXPECT_EQ(layer["vertices"], 14);
  EXPECT_EQ(layer["triangles"], 24);
  EXPECT_NEAR(layer["area"].get<double>(), 2400, 1e-9);
}

TEST_F(Program, MotionsAreTablesToo) {
  write("poses.csv", "time,x,y,z\n0,0,0,0\n2,0,0,5\n");
  ASSERT_EQ(run("sweep fx/cube.obj -m poses.csv -o moved.t4d").exitCode, 0);
  const json info = run("info moved.t4d --json").value();
  EXPECT_EQ(info["bodies"][0]["time_end"], 2);
  write("poses.csv", "time,x,y,z\n0,0,0,0\n2,0,0\n");
  refuses("sweep fx/cube.obj -m poses.csv -o out.t4d", "poses.csv:3: has 3 fields");
}

TEST_F(Program, RefusesBadMeshes) {
  const auto sweep = [](const std::string& mesh) {
    return "sweep " + mesh + " -m fx/paper-screw.json -o out.t4d";
  };
  const std::string cube = contents(folder_ / "fx" / "cube.obj");
  const auto lastFace = cube.rfind("\nf ");
  write("open.obj", cube.substr(0, lastFace + 1));
  refuses(sweep("open.obj"), "open.obj: the mesh is open: 3 boundary edges");
  std::string turned = cube;
  const auto face = turned.substr(lastFace + 3);
  write(
      "turned.obj", cube.substr(0, lastFace + 1) + "f " + [&] {
        std::istringstream in(face);
        std::string a, b, c;
        in >> a >> b >> c;
        return b + " " + a + " " + c + "\n";
      }());
  refuses(sweep("turned.obj"), "inconsistent orientation");
  write("edge.obj", cube + "v 9 9 9\nf 1 2 9\nf 2 1 9\n");
  refuses(sweep("edge.obj"), "non-manifold edge");
  write("nan.obj", "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n");
  refuses(sweep("nan.obj"), "nan.obj:3");
  write("inf.obj", "v 0 0 0\nv 1 0 inf\nv 0 1 0\nf 1 2 3\n");
  refuses(sweep("inf.obj"), "inf.obj:2");
  write("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n");
  refuses(sweep("index.obj"), "index.obj:4");
  write("empty.obj", "# nothing\n");
  refuses(sweep("empty.obj"), "no triangles");
  refuses(sweep("missing.obj"), "missing.obj");
  refuses(sweep("fx"), "fx");
}

TEST_F(Program, NoticesAnInsideOutMesh) {
  std::string text;
  std::istringstream in(contents(folder_ / "fx" / "cube.obj"));
  for (std::string line; std::getline(in, line);) {
    if (line.rfind("f ", 0) == 0) {
      std::istringstream words(line.substr(2));
      std::string a, b, c;
      words >> a >> b >> c;
      line = "f " + b + " " + a + " " + c;
    }
    text += line + "\n";
  }
  write("inside-out.obj", text);
  const Finished done = run("sweep inside-out.obj -m fx/paper-screw.json -o turned.t4d");
  EXPECT_EQ(done.exitCode, 0);
  EXPECT_NE(done.err.find("was flipped"), std::string::npos);
  EXPECT_GT(run("validate turned.t4d --json").value()["hypervolume"], 0);
}

TEST_F(Program, RefusesBadMotionsAndRules) {
  const auto motion = [&](const std::string& text, const std::string& expected) {
    write("m.json", text);
    refuses("sweep fx/cube.obj -m m.json -o out.t4d", expected);
  };
  motion(R"({"segments": [{"duration": 0}]})", "backward through time");
  motion(R"({"segments": [{"duration": -1}]})", "m.json: segment 0");
  motion(R"({"segments": [{"duration": 1, "angle_degrees": 5, "axis_direction": [0, 0, 0]}]})",
         "length 0");
  motion(R"({"segments": [{"duration": 1, "axis": [0, 0, 1]}]})", "unknown key 'axis'");
  motion("{", "not JSON");
  const std::string base = "sweep fx/cube.obj -m fx/paper-screw.json -o out.t4d ";
  misused(base + "--rv-min 1", "--rv-min: '1' is not a number from 0 to less than 1");
  misused(base + "--rv-min -0.5", "--rv-min: '-0.5'");
  misused(base + "--rv-min nan", "--rv-min: 'nan'");
  misused(base + "--steps 0", "--steps: '0' is not a whole number from 1 to 100000000");
  misused(base + "--steps -1", "--steps: '-1'");
  misused(base + "--steps ''", "--steps: ''");
  misused(base + "--max-deviation 0", "--max-deviation: '0' is not a number above 0");
  misused(base + "--tolerance 0", "--tolerance: '0' is not a number above 0");
  misused(base + "--threads 0", "--threads: '0' is not a whole number from 1 to 1024");
  refuses("sweep fx/cube.obj -m missing.json -o out.t4d", "missing.json");
}

TEST_F(Program, ShapesThatFloat32CannotHoldAreALossAndCenteringTheWayOut) {
  placeFixture("cube", 0.01, 5e6);
  ASSERT_EQ(run("sweep cube-placed.obj -m fx/rest.json -o map.t4d").exitCode, 0);
  for (const char* output : {"at.stl", "at.glb"}) {
    const Finished lost = run(std::string("slice map.t4d --time 0.5 -o ") + output);
    EXPECT_EQ(lost.exitCode, 3);
    EXPECT_NE(lost.err.find("become flat or turn over in float32"), std::string::npos) << lost.err;
    EXPECT_EQ(run(std::string("slice map.t4d --time 0.5 --center -o ") + output).exitCode, 0);
  }
  EXPECT_EQ(run("slice map.t4d --time 0.5 -o at.ply").exitCode, 0);
  EXPECT_EQ(contents(folder_ / "at.stl").substr(0, 30), "origin 5000000 5000000 5000000");
  EXPECT_EQ(run("flipbook map.t4d -n 2 -o moving.gltf").exitCode, 3);
  EXPECT_EQ(run("flipbook map.t4d -n 2 --center -o moving.gltf").exitCode, 0);
  const json gltf = json::parse(contents(folder_ / "moving.gltf"));
  EXPECT_EQ(gltf["nodes"][0]["translation"], json::array({5e6, 5e6, 5e6}));

  const std::string sweep = "sweep cube-placed.obj -m fx/rest.json --precision float32 ";
  EXPECT_EQ(run(sweep + "-o flat.t4d").exitCode, 3);
  ASSERT_EQ(run(sweep + "--center -o centered.t4d").exitCode, 0);
  EXPECT_NEAR(run("validate centered.t4d --json").value()["hypervolume"].get<double>(), 0.08, 1e-8);
  EXPECT_EQ(run("info centered.t4d --json").value()["details"]["origin"],
            json::array({5e6, 5e6, 5e6}));
  EXPECT_NE(run("info centered.t4d").out.find("origin is at (5000000, 5000000, 5000000)"),
            std::string::npos);
  ASSERT_EQ(run("slice centered.t4d --time 0.5 -o centered.gltf").exitCode, 0);
  EXPECT_EQ(json::parse(contents(folder_ / "centered.gltf"))["nodes"][0]["translation"],
            json::array({5e6, 5e6, 5e6}));
}

TEST_F(Program, EndsThatFloat32FlattensAreALoss) {
  write("far.json", R"({"segments": [{"duration": 1, "translation": [2e10, 0, 0]}]})");
  EXPECT_EQ(run("sweep fx/cube.obj -m far.json --precision float32 -o far.t4d").exitCode, 3);
  EXPECT_EQ(run("sweep fx/cube.obj -m far.json -o far.t4d").exitCode, 0);
}

TEST_F(Program, NumbersBeyondWhatHoldsAreRefusedByTheFileThatHasThem) {
  const auto moves = [&](const std::string& members) {
    write("motion.json", R"({"segments": [{"duration": 4, )" + members + "}]}");
  };
  moves(R"("translation": [1e300, 0, 0])");
  refuses("sweep fx/cube.obj -m motion.json -o out.t4d", "motion.json: segment 0");
  moves(R"("translation": [1e20, 0, 0])");
  refuses("sweep fx/cube.obj -m motion.json -o out.t4d", "motion.json: segment 0 moves the solid");
  moves(R"("axis_direction": [0, 0, 1], "angle_degrees": 1e14)");
  refuses("sweep fx/cube.obj -m motion.json -o out.t4d", "motion.json: the motion needs");
  write("late.json", R"({"start_time": 1e16, "segments": [{"duration": 4, "angle_degrees": 90,
                         "axis_direction": [0, 0, 1]}]})");
  refuses("sweep fx/cube.obj -m late.json -o out.t4d", "late.json: segment 0 lasts 4");
  refuses("sweep fx/cube.obj -m late.json --backend voxel4d --voxel-size 4 -o out.t4d",
          "late.json: ");
  placeFixture("cube", 1e80, 0);
  refuses("sweep cube-placed.obj -m fx/rest.json -o out.t4d",
          "cube-placed.obj: has coordinates of");
  placeFixture("cube", 1e40, 0);
  refuses("sweep cube-placed.obj -m fx/rest.json --backend voxel4d --voxel-size 4e40 -o out.t4d",
          "voxels of 4e+40 are requested");
  write("twice.json", R"({"segments": [{"duration": 4, "duration": 5}]})");
  refuses("sweep fx/cube.obj -m twice.json -o out.t4d", "the key 'duration' twice");
}

TEST_F(Program, AStepThatTurnsFarHasANote) {
  const std::string base = "sweep fx/cube.obj -m fx/paper-screw.json -o a.t4d --steps ";
  EXPECT_THAT(run(base + "1").err, testing::HasSubstr("t4d: note: a step of segment 0 turns by "));
  EXPECT_EQ(run(base + "8").err, "");
}

/// Compares the peak memory that the program reports: the least of a few runs, as threads that the
/// system holds up make more of it.
TEST_F(Program, MemoryDoesNotGrowWithTheMotion) {
  write("one.json", R"({"segments": [{"duration": 1, "axis_direction": [1, 0, 0],
                       "angle_degrees": 360, "translation": [20, 0, 0]}]})");
  write("ten.json", R"({"segments": [{"duration": 1, "axis_direction": [1, 0, 0],
                       "angle_degrees": 360, "translation": [20, 0, 0], "repeat": 10}]})");
  const auto peak = [&](const std::string& motion) {
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 4; ++i) {
      const json report = run("sweep fx/bolt.obj -m " + motion + " -o m.t4d --json").value();
      least = std::min(least, report["peak_bytes"].get<double>());
    }
    return least;
  };
  EXPECT_LT(peak("ten.json"), 1.1 * peak("one.json"));
}

TEST_F(Program, SweepStatesItsDeviationAndHalfTurns) {
  write("turns.csv", "t,qx,qy,qz,qw\n0,0,0,0,1\n1,0,0,1,0\n2,0,0,0,-1\n");
  const Finished done =
      run("sweep fx/cube.obj -m turns.csv --max-deviation 0.5 --json -o turns.t4d");
  ASSERT_EQ(done.exitCode, 0) << done.err;
  EXPECT_THAT(done.err, testing::HasSubstr("turns.csv: 2 pairs of poses, the first lines 2 and 3, "
                                           "are half a turn apart"));
  const json value = done.value();
  EXPECT_LE(value["chord_bound"].get<double>(), 0.5);
  EXPECT_GT(value["chord_bound"].get<double>(), 0.25);
  EXPECT_EQ(value["half_turns"]["count"], 2);
  EXPECT_EQ(value["half_turns"]["first"][1]["between"], "lines 3 and 4");
  EXPECT_THAT(run("sweep fx/cube.obj -m turns.csv --max-deviation 0.5 -o turns.t4d").out,
              testing::HasSubstr("every slice within 0."));
  refuses("sweep fx/cube.obj -m turns.csv --max-deviation 1e-300 -o none.t4d",
          "turns.csv: the motion needs");
}

TEST_F(Program, ObjectsOfAnObjAreBodies) {
  // They overlap, and one lacks a side.
  const std::string large = boxText({0.5, 0, 0}, {2.5, 2, 2});
  write("two.obj", "o small part\ng a\n" + boxText({0, 0, 0}, {1, 1, 1}) + "o large\ng b\n" +
                       large.substr(0, large.rfind("f ")));
  const json mended = run("mend two.obj --bodies object -o mended.obj --json").value();
  EXPECT_NEAR(mended["volume_after"].get<double>(), 9, 1e-12);
  EXPECT_EQ(mended["components"], 2);
  EXPECT_NE(mended["changes"][0]["text"].get<std::string>().find("body 'large': filled"),
            std::string::npos);
  for (const std::string from : {"mended.obj --bodies object", "two.obj --mend --bodies object"}) {
    const json swept =
        run("sweep " + from + " -m fx/paper-translation.json -o two.t4d --json").value();
    ASSERT_EQ(swept["bodies"].size(), 2U);
    EXPECT_EQ(swept["bodies"][0]["name"], "small part");
    EXPECT_EQ(swept["bodies"][1]["name"], "large");
    const json info = run("info two.t4d --json").value();
    EXPECT_EQ(info["bodies"][1]["name"], "large");
    const json slice = run("slice two.t4d --time 5 --json").value();
    EXPECT_NEAR(slice["volume"].get<double>(), 9, 1e-9);
  }
  refuses("sweep two.obj --bodies object -m fx/rest.json -o out.t4d", "body 'large'");
  refuses("sweep fx/open-pebble.stl --bodies object -m fx/rest.json -o out.t4d", "is not an .obj");
  misused("sweep fx/bending_*.obj --bodies group --frame-time 1 -o out.t4d", "--bodies");
}

TEST_F(Program, RealMeshesAreJudged) {
  const fs::path meshes = T4D_SHARED_MESHES;
  if (!fs::exists(meshes)) GTEST_SKIP() << "no folder " << meshes << " with real meshes";
  const auto sweep = [&](const std::string& mesh) {
    return "sweep " + (meshes / mesh).string() + " -m fx/paper-screw.json --rv-min 0.9976 ";
  };
  refuses(sweep("cube_no_bottom.obj") + "-o out.t4d", "open: 8 boundary edges");
  refuses(sweep("wingnut.obj") + "-o out.t4d", ", or --caps cone");
  EXPECT_EQ(run(sweep("wingnut.obj") + "--mend -o nut.t4d").exitCode, 0);
  EXPECT_EQ(run(sweep("cube_no_bottom.obj") + "--mend -o cube.t4d").exitCode, 0);
  refuses(
      sweep("wingnut.obj") + "-o out.t4d",
      "3 pairs of triangles do (counted from 0: 3106 with 4372, 3490 with 4372, 4306 with 4372)");
  EXPECT_EQ(run(sweep("wingnut.obj") + "--caps cone -o nut.t4d").exitCode, 0);
  const json nut = run("validate nut.t4d --json").value();
  EXPECT_EQ(nut["valid"], true);
  const double expected = 22.0966389286 * 100 * (2 + std::cos(2 * M_PI / 65)) / 3;
  EXPECT_NEAR(nut["hypervolume"].get<double>(), expected, 1e-9 * expected);

  const json fish = run(sweep("fish.obj") + "-o fish.t4d --json").value();
  EXPECT_EQ(fish["steps"], 65);
  EXPECT_EQ(fish["tetrahedra"], 14 * 21568 * 65 + fish["cap_tetrahedra"][0].get<int>() +
                                    fish["cap_tetrahedra"][1].get<int>());
  const double raw = 32 * fish["vertices"].get<double>() + 16 * fish["tetrahedra"].get<double>();
  EXPECT_LT(static_cast<double>(fs::file_size(folder_ / "fish.t4d")), raw / 20);
}

}  // namespace
}  // namespace t4d::tools
