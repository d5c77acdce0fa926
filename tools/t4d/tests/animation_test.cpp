#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tools/t4d/tests/program.h"

/// `t4d sweep` of what moves by itself: series of meshes, point caches and glTF.
namespace t4d::tools {
namespace {

TEST_F(Program, DeformationsAreSwept) {
  const json series = run("sweep fx/bending_*.obj --frame-time 0.25 -o series.t4d --json").value();
  // 288 vertices, 864 edges, 576 triangles, 8 steps.
  EXPECT_EQ(series["steps"], 8);
  EXPECT_EQ(series["tetrahedra"],
            14 * 576 * 8 + int(series["cap_tetrahedra"][0]) + int(series["cap_tetrahedra"][1]));
  EXPECT_EQ(series["folds"], json({{"prisms", 0}, {"steps", 0}, {"first", json::array()}}));
  EXPECT_EQ(series["crossings"],
            json({{"pairs", 0}, {"steps", 0}, {"unfinished_steps", 0}, {"first", json::array()}}));
  ASSERT_EQ(run("sweep fx/bending_0.obj fx/bending.pc2 --times 0:2 -o cached.t4d").exitCode, 0);
  for (const char* file : {"series.t4d", "cached.t4d"}) {
    const json judged = run(std::string("validate --deep --json ") + file).value();
    EXPECT_EQ(judged["valid"], true) << file;
    // The bending does not change the volume, nor does the interpolation.
    EXPECT_NEAR(double(judged["hypervolume"]),
                2 * double(run("slice series.t4d --time 0 --json").value()["volume"]), 1e-2);
    const json slice = run("slice " + std::string(file) + " --time 0.5 --json").value();
    EXPECT_EQ(slice["triangles"], 576);
    EXPECT_EQ(slice["closed"], true);
  }
  refuses("sweep fx/bending_[025].obj --frame-time 1 -o out.t4d", "number 1 is missing");
  refuses("sweep fx/bending_0.obj fx/torus.obj --frame-time 1 -o out.t4d", "torus.obj: has ");
  const Finished oneApart = run("sweep fx/bending_*.obj -o one-apart.t4d");
  EXPECT_EQ(oneApart.exitCode, 0);
  EXPECT_THAT(oneApart.err, testing::HasSubstr("frames are taken to be 1 apart"));
  refuses("sweep fx/cube.obj fx/bending.pc2 -o out.t4d", "bending.pc2: has 288 points");
  misused("sweep fx/bending_0.obj -o out.t4d", "--motion is required");
  misused("sweep fx/bending.pc2 fx/bending_0.obj -o out.t4d", "a point cache");
  misused("sweep fx/bending_0.obj fx/bending.pc2 --times 2:1 -o out.t4d", "'2:1' is not A:B");
  misused("sweep fx/bending_0.obj fx/bending.pc2 --steps 3 -o out.t4d", "--rv-min, --steps");
  misused("sweep fx/bending_[01].obj -m fx/rest.json -o out.t4d", "--motion is for one solid");
  misused("sweep fx/cube.obj -m fx/rest.json --between midpoint -o out.t4d",
          "--mask and --between are for --backend voxel4d");
  misused("compare a.t4d b.t4d --between distance", "are for one solid; two .t4d files");
  misused("sweep fx/bending_[01].obj --backend voxel4d --voxel-size 1 -o out.t4d",
          "needs --motion");
}

/// Vertices as text, and the same sheared and stretched.
std::array<std::string, 2> leaningKeys(const std::vector<std::array<double, 3>>& vertices) {
  std::array<std::string, 2> keys;
  for (const auto& [x, y, z] : vertices) {
    keys[0] += fmt::format("v {} {} {}\n", x, y, z);
    keys[1] += fmt::format("v {} {} {}\n", 2 * x + 0.3 * z, y, 1.5 * z + 0.2 * y);
  }
  return keys;
}

const std::vector<std::array<double, 3>> kCorners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0},
                                                     {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}};
constexpr const char* kFaces =  // the last one is the top
    "f 1 3 4 2\nf 1 2 6 5\nf 2 4 8 6\nf 4 3 7 8\nf 3 1 5 7\nf 5 6 8 7\n";

TEST_F(Program, WhatFillsAHoleOfADeformationMovesWithIt) {
  const auto keys = leaningKeys(kCorners);
  const std::string open = std::string(kFaces).substr(0, std::string(kFaces).rfind("f "));
  for (int k = 0; k < 2; ++k) {
    write(fmt::format("whole_{}.obj", k), keys[k] + kFaces);
    write(fmt::format("open_{}.obj", k), keys[k] + open);
  }
  ASSERT_EQ(run("sweep whole_*.obj --times 0:1 -o whole.t4d").exitCode, 0);
  refuses("sweep open_*.obj --times 0:1 -o open.t4d", "try: --mend\n");
  const Finished done = run("sweep open_*.obj --times 0:1 --mend -o open.t4d --json");
  ASSERT_EQ(done.exitCode, 0) << done.err;
  EXPECT_EQ(done.value()["mend"]["changes"][0]["kind"], "hole");
  for (const char* time : {"0", "0.25", "0.5", "0.875", "1"}) {
    const double whole =
        run(fmt::format("slice whole.t4d --time {} --json", time)).value()["volume"];
    const double mended =
        run(fmt::format("slice open.t4d --time {} --json", time)).value()["volume"];
    EXPECT_NEAR(mended, whole, 1e-12 * whole) << time;
  }
}

TEST_F(Program, AdviceOnADeformationWorks) {
  // A sheet; two cubes that cross; a cube without its top that another one crosses; a surface that
  // crosses itself, closed and open.
  const std::string open = std::string(kFaces).substr(0, std::string(kFaces).rfind("f "));
  const auto keys = leaningKeys(kCorners);
  auto moved = kCorners;
  for (auto& [x, y, z] : moved) x += 0.5, y += 0.25, z += 0.125;
  const auto other = leaningKeys(moved);
  std::string second;
  for (const char* face : {"f 9 11 12 10", "f 9 10 14 13", "f 10 12 16 14", "f 12 11 15 16",
                           "f 11 9 13 15", "f 13 14 16 15"}) {
    second += face + std::string("\n");
  }
  // A tetrahedron one of whose vertices is below its base, beside it.
  const auto crossed = leaningKeys({{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {0, 0, 4}, {1, 1, -1}});
  const std::string bent = "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 5 4\nf 2 3 5\nf 3 4 5\n";
  struct Case {
    const char* name;
    std::array<std::string, 2> files;
    const char* advice;
  };
  const auto with = [](const std::array<std::string, 2>& vertices, const std::string& faces) {
    return std::array{vertices[0] + faces, vertices[1] + faces};
  };
  const std::array both{keys[0] + other[0], keys[1] + other[1]};
  const Case cases[] = {
      {"sheet", with(keys, "f 1 3 4 2\n"), "try: --mend --thicken 0.007\n"},
      {"crossing", with(both, kFaces + second), "try: --bodies component\n"},
      {"open", with(both, open + second), "try: --mend --bodies component\n"},
      {"bent", with(crossed, bent), "try: --caps cone\n"},
  };
  for (const auto& [name, files, advice] : cases) {
    for (int k = 0; k < 2; ++k) write(fmt::format("{}_{}.obj", name, k), files[k]);
    const std::string sweep = fmt::format("sweep {}_*.obj --times 0:1 -o {}.t4d ", name, name);
    const Finished refused = run(sweep);
    EXPECT_EQ(refused.exitCode, 4) << name;
    EXPECT_THAT(refused.err, testing::HasSubstr(advice)) << name;
    const Finished done =
        run(sweep + std::string(advice).substr(5, std::string(advice).size() - 6));
    EXPECT_EQ(done.exitCode, 0) << name << done.err;
    EXPECT_EQ(run(fmt::format("validate --deep {}.t4d --json", name)).value()["valid"], true)
        << name;
  }
  EXPECT_EQ(run("info crossing.t4d --json").value()["bodies"][1]["name"], "crossing_0 2");
}

TEST_F(Program, AUnionIsOneSolidOfAllThatOverlaps) {
  // Two boxes of 1 x 1 x 1, one of them without its top, overlap by a half and move apart until
  // they share a face: at time t a volume of 1.5 + t / 2.
  const std::string open = std::string(kFaces).substr(0, std::string(kFaces).rfind("f "));
  std::string second;
  for (const char* face : {"f 9 11 12 10", "f 9 10 14 13", "f 10 12 16 14", "f 12 11 15 16",
                           "f 11 9 13 15", "f 13 14 16 15"}) {
    second += face + std::string("\n");
  }
  for (int k = 0; k < 2; ++k) {
    std::string text;
    for (const double shift : {0.0, 0.5 + 0.5 * k}) {
      for (const auto& [x, y, z] : kCorners) text += fmt::format("v {} {} {}\n", x + shift, y, z);
    }
    write(fmt::format("apart_{}.obj", k), text + open + second);
  }
  const json done =
      run("sweep apart_*.obj --times 0:1 --mend --union --voxel-size 0.05 -o one.t4d --json")
          .value();
  EXPECT_EQ(done["voxel_size"], 0.05);
  EXPECT_EQ(run("validate --deep one.t4d --json").value()["valid"], true);
  for (const double time : {0.0, 0.5, 1.0}) {
    const json slice = run(fmt::format("slice one.t4d --time {} --json", time)).value();
    EXPECT_NEAR(slice["volume"], 1.5 + time / 2, 0.02) << time;
  }
  misused("sweep apart_*.obj --union --bodies component -o out.t4d", "--union makes one solid");
  misused("sweep fx/cube.obj -m fx/rest.json --union -o out.t4d", "--union is for an animation");
}

TEST_F(Program, AUnionSaysWhatItTakesAndHasABoundOfFrames) {
  for (int k = 0; k < 2; ++k) {
    std::string text;
    for (const auto& [x, y, z] : kCorners) text += fmt::format("v {} {} {}\n", x + 40 * k, y, z);
    write(fmt::format("far_{}.obj", k), text + kFaces);
  }
  // 400 voxels of way: one voxel a step would be 400 steps.
  const std::string sweep =
      "sweep far_*.obj --times 0:1 --union --voxel-size 0.1 -o far.t4d --json";
  const Finished done = run(sweep);
  ASSERT_EQ(done.exitCode, 0) << done.err;
  EXPECT_EQ(done.value()["steps"], 299);
  EXPECT_THAT(done.err, testing::HasSubstr("note: a union in 300 frames of 410 x 10 x 10 voxels: "
                                           "some "));
  EXPECT_THAT(done.err,
              testing::HasSubstr("note: points move up to 1.34 voxels between two frames; "
                                 "401 frames over the whole motion would keep them within "
                                 "one"));
  const Finished all = run(sweep + " --frames 401");
  EXPECT_EQ(all.value()["steps"], 400);
  EXPECT_THAT(all.err, testing::HasSubstr("note: a union in 401 frames of "));
  EXPECT_THAT(all.err, testing::Not(testing::HasSubstr("points move")));
  // The result agrees with the expectation within a factor of two.
  const std::string some = all.err.substr(all.err.find("some ") + 5);
  std::string digits = some.substr(0, some.find(' '));
  std::erase(digits, ',');
  const double expected = std::stod(digits);
  const double made = all.value()["tetrahedra"];
  EXPECT_GT(made, expected / 2);
  EXPECT_LT(made, expected * 2);
}

TEST_F(Program, TextureCoordinatesOfAnimationsAreKept) {
  // A box with the same square on each side.
  const auto keys = leaningKeys(kCorners);
  const std::string square = "vt 0 0\nvt 1 0\nvt 1 0.5\nvt 0 0.5\n";
  const std::string faces =
      "f 1/1 3/2 4/3 2/4\nf 1/1 2/2 6/3 5/4\nf 2/1 4/2 8/3 6/4\n"
      "f 4/1 3/2 7/3 8/4\nf 3/1 1/2 5/3 7/4\nf 5/1 6/2 8/3 7/4\n";
  write("uv.obj", keys[0] + square + faces);
  ASSERT_EQ(run("sweep uv.obj -m fx/skew-axis.json -o uv.t4d").exitCode, 0);
  // Other attributes of triangles are lost.
  ASSERT_EQ(run("flipbook uv.t4d -n 3 --rigid --attributes -o uv.gltf").exitCode, 3);
  const Finished swept = run("sweep uv.gltf -o again.t4d");
  EXPECT_EQ(swept.exitCode, 0) << swept.err;
  // A hole has the coordinates of its rim.
  json gltf = json::parse(contents(folder_ / "uv.gltf"));
  json& corners = gltf["accessors"][int(gltf["meshes"][0]["primitives"][0]["indices"])]["count"];
  corners = int(corners) - 6;
  write("open.gltf", gltf.dump());
  ASSERT_EQ(run("sweep open.gltf --mend -o open.t4d").exitCode, 0);
  for (const char* file : {"uv.t4d", "again.t4d", "open.t4d"}) {
    run(fmt::format("slice {} --time 0 --light --attributes -o s.obj", file));
    const std::string text = contents(folder_ / "s.obj");
    for (const char* line : {"\nvt 0 0\n", "\nvt 1 0\n", "\nvt 1 0.5\n", "\nvt 0 0.5\n"}) {
      EXPECT_THAT(text, testing::HasSubstr(line)) << file;
    }
  }
}

TEST_F(Program, DeformationsKeepTheLookOfTheirFirstMesh) {
  const auto keys = leaningKeys(kCorners);
  const std::string faces =
      "f 1/1 3/2 4/3 2/4\nf 1/1 2/2 6/3 5/4\nusemtl wood\nf 2/1 4/2 8/3 6/4\n"
      "f 4/1 3/2 7/3 8/4\nf 3/1 1/2 5/3 7/4\nf 5/1 6/2 8/3 7/4\n";
  for (std::size_t k = 0; k < keys.size(); ++k) {
    write(fmt::format("look_{}.obj", k), keys[k] + "vt 0 0\nvt 1 0\nvt 1 0.5\nvt 0 0.5\n" + faces);
  }
  for (const std::string more : {"", " --mend"}) {
    ASSERT_EQ(run("sweep look_*.obj --times 0:1 -o look.t4d" + more).exitCode, 0);
    EXPECT_EQ(run("info look.t4d --json").value()["details"]["materials"], (json{"", "wood"}));
    run("slice look.t4d --time 0 --light --attributes -o look.obj");
    const std::string text = contents(folder_ / "look.obj");
    for (const char* line : {"\nvt 1 0.5\n", "\nusemtl wood\n"}) {
      EXPECT_THAT(text, testing::HasSubstr(line));
    }
  }
}

TEST_F(Program, FoldsOfADeformationAreReported) {
  // The solid turns inside out.
  write("in.obj", "v -1 -1 -1\nv 2 0 0\nv 0 2 0\nv 0 0 2\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  write("out.obj", "v 1 1 1\nv -2 0 0\nv 0 -2 0\nv 0 0 -2\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  const Finished done = run("sweep in.obj out.obj --times 1:3 --caps cone -o turned.t4d --json");
  EXPECT_EQ(done.exitCode, 0);
  EXPECT_NE(done.err.find("4 prisms in 1 of 1 steps fold"), std::string::npos) << done.err;
  const json folds = done.value()["folds"];
  EXPECT_EQ(folds["prisms"], 4);
  EXPECT_EQ(folds["first"][0]["time"], json::array({1, 3}));
  EXPECT_EQ(folds["first"][0]["triangle"], 0);
}

TEST_F(Program, CrossingsBetweenTheKeysOfADeformationAreReported) {
  // One tetrahedron of two passes through the other.
  const std::string faces =
      "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\nf 5 7 6\nf 5 6 8\nf 5 8 7\nf 6 7 8\n";
  const std::string still = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
  write("left.obj", still + "v -3 0.1 0.2\nv -2 0.1 0.2\nv -3 1.1 0.2\nv -3 0.1 1.2\n" + faces);
  write("right.obj", still + "v 3 0.1 0.2\nv 4 0.1 0.2\nv 3 1.1 0.2\nv 3 0.1 1.2\n" + faces);
  const Finished done = run("sweep left.obj right.obj --times 0:6 -o through.t4d --json");
  EXPECT_EQ(done.exitCode, 0);
  EXPECT_NE(done.err.find("in 1 of 1 steps meet between keys"), std::string::npos) << done.err;
  const json crossings = done.value()["crossings"];
  EXPECT_GT(crossings["pairs"], 2);
  EXPECT_EQ(crossings["steps"], 1);
  const json& first = crossings["first"][0];
  EXPECT_EQ(first["time"], json::array({0, 6}));
  EXPECT_GE(first["at"], 2);
  EXPECT_LE(first["at"], 4);
  EXPECT_LE(first["triangles"][0], 3);
  EXPECT_GE(first["triangles"][1], 4);
  EXPECT_EQ(done.value()["folds"]["prisms"], 0);
}

TEST_F(Program, WritesUsd) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  const auto written = run("flipbook cube.t4d --frames 5 --fps 24 -o f.usda --json").value();
  EXPECT_EQ(written["files"], json({"f.usda"}));
  EXPECT_EQ(written["frames"], 5);
  EXPECT_EQ(run("flipbook cube.t4d --frames 5 --fps 24 -o f.usdz").exitCode, 0);
  EXPECT_EQ(run("flipbook cube.t4d -n 2 --rigid -o r.usda").exitCode, 0);
  EXPECT_EQ(run("flipbook cube.t4d -n 2 --exact -o e.usda").exitCode, 0);
  misused("flipbook cube.t4d -n 2 --visibility -o f.usda", "--visibility is for glTF");
  misused("flipbook cube.t4d -n 2 --quantize 12 -o f.usda", "--quantize: only .glb and .gltf");
  misused("flipbook cube.t4d -n 2 -o f.usdc", "does not end with .glb, .gltf, .usda or .usdz");
  EXPECT_EQ(run("frames cube.t4d -n 3 --fps 12 --format usda -o set").exitCode, 0);
  EXPECT_THAT(contents(folder_ / "set/frames.usda"),
              testing::HasSubstr("timeCodesPerSecond = 12\n"));
  EXPECT_EQ(run("slice cube.t4d --time 1 -o one.usdz").exitCode, 0);
}

TEST_F(Program, CompressedFlipbooksAreReadAsWhatWasWritten) {
  if (run("slice --help").out.find("--meshopt") == std::string::npos) GTEST_SKIP();
  ASSERT_EQ(run("sweep fx/torus.obj -m fx/skew-axis.json -o torus.t4d").exitCode, 0);
  for (const std::string kind : {"", "--rigid", "--morph"}) {
    const auto read = [&](const std::string& encoding) {
      const std::string options = kind + " " + encoding;
      const Finished made = run("flipbook torus.t4d -n 5 -o torus.glb " + options);
      EXPECT_EQ(made.exitCode, made.err.find("without meshoptimizer") == made.err.npos ? 0 : 2);
      if (made.exitCode != 0) return std::string();
      EXPECT_EQ(run("sweep torus.glb -o again.t4d").exitCode, 0) << options;
      EXPECT_EQ(run("slice again.t4d --time 0.3 -o slice.stl").exitCode, 0) << options;
      return contents(folder_ / "slice.stl");
    };
    const std::string packed = read("--meshopt");
    EXPECT_TRUE(packed.empty() || packed == read("")) << kind;
  }
}

TEST_F(Program, OtherAnimationsAreNamedInANote) {
  ASSERT_EQ(run("sweep fx/two-boxes.obj -m fx/skew-axis.json -o boxes.t4d").exitCode, 0);
  ASSERT_EQ(run("flipbook boxes.t4d -n 2 --rigid -o two.gltf").exitCode, 0);
  json gltf = json::parse(contents(folder_ / "two.gltf"));
  gltf["animations"].push_back(gltf["animations"][0]);
  gltf["animations"][1]["name"] = "the other";
  write("two.gltf", gltf.dump());
  const std::string note = "--animation takes another ('the other'), or all";
  EXPECT_THAT(run("sweep two.gltf -o a.t4d").err, testing::HasSubstr(note));
  EXPECT_THAT(run("sweep two.gltf --animation motion -o a.t4d").err,
              testing::Not(testing::HasSubstr("animation")));
  refuses("sweep two.gltf --animation all -o a.t4d", "as another animation that is read does");
  // One turns the body, the other moves it.
  gltf["animations"][0]["channels"].erase(1);
  gltf["animations"][1]["channels"].erase(0);
  write("two.gltf", gltf.dump());
  ASSERT_EQ(run("sweep two.gltf --animation all --tolerance 1e-4 -o all.t4d").exitCode, 0);
  gltf["animations"][0]["channels"].push_back(gltf["animations"][1]["channels"][0]);
  gltf["animations"].erase(1);
  write("two.gltf", gltf.dump());
  ASSERT_EQ(run("sweep two.gltf --tolerance 1e-4 -o one.t4d").exitCode, 0);
  EXPECT_EQ(run("measure all.t4d -n 3 --json").out, run("measure one.t4d -n 3 --json").out);
}

TEST_F(Program, ListsWhatItDoesNotTakeOfGltf) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  ASSERT_EQ(run("slice cube.t4d --time 0 -o still.glb").exitCode, 0);
  ASSERT_EQ(run("flipbook cube.t4d --frames 2 -o moving.glb").exitCode, 0);
  const std::string lost = "t4d: lost: the animation of 2 nodes: the mesh is as it is at rest\n";
  for (const std::string verb :
       {"sweep $ -m fx/rest.json -o a.t4d",
        "voxelize $ -m fx/rest.json --voxel-size 4 --frames 2 -o a",
        "compare $ -m fx/rest.json --voxel-size 4 --frames 2 --caps graded"}) {
    const auto with = [&](const char* model) {
      return run(std::string(verb).replace(verb.find('$'), 1, model));
    };
    const Finished still = with("still.glb");
    EXPECT_EQ(still.exitCode, 0) << verb << still.err;
    EXPECT_EQ(still.err, "");
    const Finished moving = with("moving.glb");
    EXPECT_EQ(moving.exitCode, 3) << verb << moving.err;
    EXPECT_THAT(moving.err, testing::HasSubstr(lost));
  }
}

TEST_F(Program, ACollectionIsASeriesWithItsTimes) {
  ASSERT_EQ(run("sweep fx/bending_*.obj --frame-time 0.25 -o mesh.t4d").exitCode, 0);
  ASSERT_EQ(run("frames mesh.t4d --count 5 --light -o out/a_%d.vtp").exitCode, 0);
  const Finished swept = run("sweep out/a.pvd -o swept.t4d");
  EXPECT_EQ(swept.exitCode, 0) << swept.err;
  EXPECT_THAT(swept.err, testing::Not(testing::HasSubstr("1 apart")));
  const Finished woven = run("weave out/a.pvd --voxel-size 2 -o woven.t4d");
  EXPECT_EQ(woven.exitCode, 0) << woven.err;
  for (const char* name : {"swept.t4d", "woven.t4d"}) {
    const json info = run(std::string("info --json ") + name).value();
    EXPECT_EQ(info["time_begin"], 0) << name;
    EXPECT_EQ(info["time_end"], 2) << name;
  }
  ASSERT_EQ(run("weave out/a.pvd --voxel-size 2 --frame-time 3 -o woven.t4d").exitCode, 0);
  EXPECT_EQ(run("info --json woven.t4d").value()["time_end"], 12);
  for (const char* command :
       {"weave out/a.pvd -o out.t4d", "weave out/a.pvd out/a_0.vtp --voxel-size 2 -o out.t4d",
        "weave out/a.pvd --voxel-size 2 --start-time 1 -o out.t4d",
        "sweep out/a.pvd out/a_0.vtp -o out.t4d", "sweep out/a.pvd -m fx/rest.json -o out.t4d"}) {
    EXPECT_EQ(run(command).exitCode, 2) << command;
    EXPECT_FALSE(fs::exists(folder_ / "out.t4d")) << command;
  }
  // A mesh that is missing is found before the others are woven.
  ASSERT_EQ(shell("rm out/a_3.vtp"), 0);
  for (const char* command :
       {"weave out/a.pvd --voxel-size 2 -o out.t4d", "sweep out/a.pvd -o out.t4d"}) {
    const Finished refused = run(command);
    EXPECT_EQ(refused.exitCode, 4) << command;
    EXPECT_EQ(refused.err, "t4d: out/a.pvd:8: names the file 'a_3.vtp': no such file\n") << command;
  }
}

}  // namespace
}  // namespace t4d::tools
