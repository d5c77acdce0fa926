#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>

#include "tools/t4d/tests/program.h"

/// `t4d slice`, and the formats of what it writes.
namespace t4d::tools {
namespace {

TEST_F(Program, WritesEveryFormatAndPlaysTwo) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  for (const char* name : {"a.glb", "a.gltf", "a.stl", "a.ply", "a.obj"}) {
    EXPECT_EQ(run(std::string("slice cube.t4d --time -0 -o ") + name).exitCode, 0) << name;
    EXPECT_GT(fs::file_size(folder_ / name), 100U);
  }
  for (const char* cut : {"--x 1", "--y -2.5", "--z 30", "--hyperplane 1,2,3,-4,5"}) {
    const Finished done = run(std::string("slice cube.t4d -o b.glb --json ") + cut);
    EXPECT_EQ(done.exitCode, 0) << done.err;
    EXPECT_EQ(done.value()["closed"], true);
    EXPECT_GT(done.value()["volume"], 0);
  }
  EXPECT_EQ(run("flipbook cube.t4d --frames 5 -o f.glb --json").value()["frames"], 5);
  EXPECT_EQ(run("flipbook cube.t4d --times 1:2:3 -o f.gltf --json").value()["frames"], 3);
}

TEST_F(Program, LightSlicesAreTheSolidAndAsLargeAsExactOnes) {
  ASSERT_EQ(run("sweep fx/torus.obj -m fx/skew-axis.json --rv-min 0.9 -o torus.t4d").exitCode, 0);
  const auto exact = run("slice torus.t4d --time 0.31 --json").value();
  const auto light = run("slice torus.t4d --time 0.31 --light --json").value();
  EXPECT_EQ(exact["light"], false);
  EXPECT_EQ(exact["distance"], 0);
  EXPECT_EQ(light["light"], true);
  EXPECT_GT(light["distance"], 0);
  EXPECT_EQ(exact["triangles"].get<int>(), 13 * light["triangles"].get<int>());
  EXPECT_NEAR(light["volume"].get<double>() / exact["volume"].get<double>(), 1, 1e-12);
  EXPECT_THAT(run("slice torus.t4d --time 0.31 --light").out,
              testing::HasSubstr("light: the layers' triangles, within "));
  // The triangles of the input, in its order.
  ASSERT_EQ(run("slice torus.t4d --time 0.31 --light -o light.obj").exitCode, 0);
  const auto faces = [&](const char* name) {
    std::string all;
    std::ifstream file(folder_ / name);
    for (std::string line; std::getline(file, line);) {
      if (line.starts_with("f ")) all += line + "\n";
    }
    return all;
  };
  EXPECT_EQ(faces("light.obj"), faces("fx/torus.obj"));

  const auto few = run("flipbook torus.t4d --frames 7 -o light.glb --json").value();
  const auto many = run("flipbook torus.t4d --frames 7 -o exact.glb --exact --json").value();
  EXPECT_EQ(few["triangles"].get<int>(), 7 * light["triangles"].get<int>());
  EXPECT_EQ(few["light"], true);
  EXPECT_EQ(many["light"], false);
  EXPECT_LT(6 * few["bytes"].get<int>(), many["bytes"].get<int>());
  EXPECT_EQ(run("slice torus.t4d --x 0 --light").exitCode, 2);

  // Slabs that are no prisms.
  ASSERT_EQ(run("sweep fx/cube.obj -m fx/rest.json --prism 3 -o three.t4d").exitCode, 0);
  const Finished done = run("slice three.t4d --time 0.5 --light --json");
  EXPECT_EQ(done.exitCode, 0);
  EXPECT_EQ(done.value()["light"], false);
  EXPECT_THAT(done.err,
              testing::HasSubstr("is exact, because its slab does not consist of prisms"));
  EXPECT_THAT(run("flipbook three.t4d -n 3 -o three.glb").err,
              testing::HasSubstr("has exact slices, because a slab does not consist of prisms"));
}

TEST_F(Program, TextureCoordinatesOfCornersComeOutOfLightSlices) {
  // A cube with a texture square on every side, so that corners at one vertex differ, and inside
  // out, so that the sweep turns its triangles over.
  std::ofstream obj(folder_ / "cube.obj");
  for (int i = 0; i < 8; ++i) {
    obj << "v " << (i & 1) << " " << (i >> 1 & 1) << " " << (i >> 2) << "\n";
  }
  obj << "vt 0 0\nvt 0.25 0\nvt 0.25 0.5\nvt 0 0.5\nusemtl wood\n"
         "f 1/1 2/2 4/3 3/4\nf 5/1 7/2 8/3 6/4\nf 1/1 5/2 6/3 2/4\n"
         "f 3/1 4/2 8/3 7/4\nf 1/1 3/2 7/3 5/4\nf 2/1 6/2 8/3 4/4\n";
  obj.close();
  for (const char* step : {"sweep cube.obj -m fx/rest.json --body cube -o a.t4d",
                           "slice a.t4d --time 0.5 --light --attributes -o a.glb",
                           "sweep a.glb -m fx/rest.json --body cube -o b.t4d",
                           "slice b.t4d --time 0.5 --light --attributes -o b.glb",
                           "slice a.t4d --time 0.5 --light --attributes -o a.ply"}) {
    const Finished done = run(step);
    EXPECT_TRUE(done.exitCode == 0 || done.exitCode == 3) << step << done.err;
  }
  EXPECT_EQ(run("info a.t4d --json").value()["details"]["materials"], (json{"", "wood"}));
  const auto bytes = [&](const char* name) { return contents(folder_ / name); };
  EXPECT_THAT(bytes("a.ply"), testing::HasSubstr("property float uv_corners_5"));
  EXPECT_THAT(bytes("a.glb"), testing::HasSubstr("TEXCOORD_0"));
  EXPECT_EQ(bytes("a.glb"), bytes("b.glb"));
  // .obj has them, too, and so have bodies that move or morph: all but the vertices is the same.
  const auto facesOf = [&](const std::string& mesh) {
    EXPECT_EQ(run("slice " + mesh + ".t4d --time 0.5 --light --attributes -o s.obj").exitCode, 3);
    std::string all;
    std::ifstream file(folder_ / "s.obj");
    for (std::string line; std::getline(file, line);) {
      if (!line.starts_with("v ")) all += line + "\n";
    }
    return all;
  };
  EXPECT_THAT(facesOf("a"), testing::HasSubstr("vt 0.25 0.5\n"));
  for (const std::string kind : {"rigid", "morph"}) {
    EXPECT_EQ(run("flipbook a.t4d -n 2 --attributes -o book.glb --" + kind).exitCode, 3);
    EXPECT_EQ(run("sweep book.glb -m fx/rest.json --body cube -o " + kind + ".t4d").exitCode, 3);
    EXPECT_EQ(facesOf(kind), facesOf("a")) << kind;
  }
}

TEST_F(Program, NormalsAndColoursAreWrittenOnDemand) {
  ASSERT_EQ(run("sweep fx/two-boxes.obj -m fx/rest.json -o boxes.t4d").exitCode, 0);
  const auto bytes = [&](const char* name) { return contents(folder_ / name); };
  const std::string look = " --normals crease:30 --color body ";
  for (const char* name : {"b.glb", "b.ply", "b.obj", "b.vtp"}) {
    ASSERT_EQ(run("slice boxes.t4d --time 0.5 --light -o " + std::string(name) + look).exitCode, 0);
  }
  EXPECT_THAT(bytes("b.glb"), testing::HasSubstr("\"NORMAL\""));
  EXPECT_THAT(bytes("b.ply"), testing::HasSubstr("element vertex 48\n"));  // 3 at each corner
  EXPECT_THAT(bytes("b.ply"), testing::HasSubstr("property float nz\nproperty uchar red\n"));
  EXPECT_THAT(bytes("b.obj"), testing::HasSubstr("vn 0 0 1\n"));
  EXPECT_THAT(bytes("b.vtp"), testing::HasSubstr("<PointData Normals=\"Normals\">"));
  // A reader merges the repeated vertices again.
  EXPECT_EQ(run("sweep b.ply -m fx/rest.json -o again.t4d").exitCode, 0);
  EXPECT_EQ(run("sweep b.obj -m fx/rest.json -o again.t4d").exitCode, 0);
  EXPECT_EQ(run("slice boxes.t4d --time 0.5 -o b.stl" + look).exitCode, 3);
  EXPECT_EQ(run("slice boxes.t4d --time 0.5 --normals flat -o b.stl").exitCode, 0);
  EXPECT_EQ(run("slice boxes.t4d --x 0 --color time -o b.ply").exitCode, 2);
  EXPECT_EQ(run("slice boxes.t4d --x 0 --color triangle -o b.ply").exitCode, 0);
  EXPECT_EQ(run("slice boxes.t4d --x 8 --color attribute:heat -o b.ply").exitCode, 4);
  EXPECT_EQ(run("slice boxes.t4d --x 0 --color heat -o b.ply").exitCode, 2);
  EXPECT_EQ(run("slice boxes.t4d --x 0 --quantize 12 -o b.ply").exitCode, 2);
  EXPECT_EQ(run("slice boxes.t4d --x 0 --quantize 17 -o b.glb").exitCode, 2);
  EXPECT_EQ(run("flipbook boxes.t4d -n 2 --rigid --quantize 12 -o b.glb").exitCode, 2);
  EXPECT_EQ(run("flipbook boxes.t4d -n 2 --morph --quantize 16 -o b.glb").exitCode, 2);
  EXPECT_EQ(run("slice boxes.t4d --x 0 --normals crease:200 -o b.ply").exitCode, 2);
}

TEST_F(Program, SaysThatASliceIsEmpty) {
  ASSERT_EQ(run("sweep fx/cube.obj -m fx/rest.json -o cube.t4d").exitCode, 0);
  const Finished empty = run("slice cube.t4d --x 1000");
  EXPECT_EQ(empty.exitCode, 0);
  EXPECT_NE(empty.err.find("note: the slice is empty"), std::string::npos) << empty.err;
  EXPECT_EQ(run("slice cube.t4d --x 0.1").err, "");
}

TEST_F(Program, RefusesTimesOutsideAndUnknownOutputs) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  refuses("slice cube.t4d --time 65 -o out.glb",
          "cube.t4d: time 65 is outside the mesh, which lasts from 0 to 64");
  refuses("slice cube.t4d --time -1 -o out.glb", "lasts from 0 to 64");
  EXPECT_EQ(run("slice cube.t4d --hyperplane 0,0,0,0,1").exitCode, 2);
  EXPECT_EQ(run("slice cube.t4d --hyperplane 0 0 1 -2 0.5 --json").out,
            run("slice cube.t4d --hyperplane 0,0,1,-2,0.5 --json").out);
  EXPECT_EQ(run("slice cube.t4d --hyperplane 1e-170,0,0,0,0").exitCode, 0);
  misused("slice cube.t4d --time nan -o out.glb", "--time: 'nan' is not a number");
  misused("slice cube.t4d --hyperplane 0,0,0,0,1 -o out.glb", "--hyperplane: ");
  misused("slice cube.t4d --time 1 -o out.xyz",
          ".stl, .obj, .ply, .off, .vtp, .gltf, .glb, .usda or .usdz");
  misused("flipbook cube.t4d --frames 2 -o out.stl", "--output: ");
  misused("recover cube.t4d -o out.stl", "does not end with .t4d");
  misused("flipbook cube.t4d --frames 2.5 -o out.glb",
          "--frames: '2.5' is not a whole number from 1 to 100000");
  misused("flipbook cube.t4d --frames 2 --fps 0 -o out.glb", "--fps: '0' is not a number above 0");
  refuses("slice cube.t4d --time 1 --body lid -o out.glb", "has no body 'lid'; it has paper-cube");
  refuses("flipbook cube.t4d --times 60:70:3 -o out.glb", "time 65 is outside");
  refuses("slice missing.t4d --time 1 -o out.glb", "missing.t4d: cannot open: No such file");
  refuses("info fx/cube.obj", "is not a .t4d file");
  refuses("info fx", "fx: is a folder");
}

TEST_F(Program, LossIsListedAndExit3) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  const Finished lost = run("slice cube.t4d --time 1 --attributes -o a.stl");
  EXPECT_EQ(lost.exitCode, 3);
  EXPECT_NE(lost.err.find("triangle"), std::string::npos);
  EXPECT_NE(lost.err.find("kind"), std::string::npos);
  EXPECT_EQ(run("slice cube.t4d --time 1 --attributes -o a.ply").exitCode, 0);
}

}  // namespace
}  // namespace t4d::tools
