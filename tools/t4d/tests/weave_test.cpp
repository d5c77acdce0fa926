#include <algorithm>
#include <cmath>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <string>

#include <gmock/gmock.h>

#include "tools/t4d/tests/program.h"

/// `t4d weave` of grids, volumes and triangle meshes.
namespace t4d::tools {
namespace {

/// A sphere as .obj, of `around` by `across` quadrilaterals and triangles at the poles.
std::string ballText(double radius, double x, int around, int across) {
  std::string text;
  const auto point = [&](double height, double angle) {
    const double ring = radius * std::sin(height);
    text += "v " + std::to_string(x + ring * std::cos(angle)) + " " +
            std::to_string(ring * std::sin(angle)) + " " +
            std::to_string(radius * std::cos(height)) + "\n";
  };
  const double pi = std::acos(-1.0);
  point(0, 0);
  for (int i = 1; i < across; ++i) {
    for (int j = 0; j < around; ++j) point(pi * i / across, 2 * pi * j / around);
  }
  point(pi, 0);
  const auto at = [&](int i, int j) { return 2 + (i - 1) * around + j % around; };
  const int last = 2 + (across - 1) * around;
  const auto face = [&](std::initializer_list<int> corners) {
    text += "f";
    for (const int corner : corners) text += " " + std::to_string(corner);
    text += "\n";
  };
  for (int j = 0; j < around; ++j) {
    face({1, at(1, j), at(1, j + 1)});
    for (int i = 1; i + 1 < across; ++i) {
      face({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
    }
    face({at(across - 1, j), last, at(across - 1, j + 1)});
  }
  return text;
}

TEST_F(Program, SaysWhichPartsAreLostBetweenFrames) {
  // Plates of 3 voxels that move by 3 of them.
  std::string samples = "raw uint8 8 8 12 3 little\n";
  for (int frame = 0; frame < 3; ++frame) {
    for (int z = 0; z < 12; ++z) {
      samples += std::string(64, z >= 3 * frame && z < 3 * frame + 3 ? '\1' : '\0');
    }
  }
  write("plate.raw", samples);
  const Finished done = run("weave plate.raw --label 1 -o plate.t4d --json");
  EXPECT_EQ(done.exitCode, 0);
  EXPECT_THAT(
      done.err,
      testing::HasSubstr("a part of 192 voxels at (3.5, 3.5, 1) moves by its own width or more"));
  const json lost = done.value()["parts_lost"];
  ASSERT_EQ(lost.size(), 2U);
  EXPECT_EQ(lost[1], json::parse(R"({"frame": 1, "time": 1.0, "point": [3.5, 3.5, 4.0],
                                     "voxels": 192})"));
  EXPECT_EQ(run("weave plate.raw --label 1 --fail-on-lost-parts -o plate.t4d").exitCode, 1);
  EXPECT_TRUE(fs::exists(folder_ / "plate.t4d"));
  EXPECT_EQ(run("weave plate.raw --label 1 --between midpoint -o jumps.t4d").exitCode, 0);
  EXPECT_EQ(run("measure plate.t4d --times 0.5:0.5:1 --json").value()["samples"][0]["components"],
            run("measure jumps.t4d --times 0.5:0.5:1 --json").value()["samples"][0]["components"]);
  const json voxels =
      run("voxelize fx/cube.obj -m fx/paper-voxel.json --voxel-size 0.25 --frames 4 "
          "-o frames --fail-on-lost-parts --json")
          .value();
  EXPECT_EQ(voxels["parts_lost"].size(), 3U);
}

TEST_F(Program, WeaveSaysWhatItDoesNotRead) {
  refuses("weave fx/labels.nrrd -o out.t4d", "--label N");
  refuses("weave fx/labels.nrrd --label 2 --start-time 1e300 -o out.t4d",
          "frame 0 is at time 1e+300; the largest possible is 1e+70");
  write("grid.xyz", "no grid");
  refuses("weave grid.xyz -o out.t4d", "not a volume by its extension; expected .vdb, .nrrd");
  ASSERT_EQ(shell("mkdir volumes && cp fx/labels.nrrd volumes"), 0);
  refuses("weave volumes -o out.t4d",
          "is a folder of 1 volume, and none is a .vdb file; name the "
          "volumes, as volumes/*.nrrd");
  std::string minusOnes = "raw float32 2 2 2 2\n";
  for (int i = 0; i < 16; ++i) minusOnes += std::string("\0\0\x80\xBF", 4);
  write("minus.raw", minusOnes);
  EXPECT_THAT(run("weave minus.raw --frame-time 1 -o minus.t4d").err,
              testing::HasSubstr("taken as distances"));
}

TEST_F(Program, WeavesARegion) {
  ASSERT_EQ(run("weave fx/labels.nrrd --label 2 -o whole.t4d").exitCode, 0);
  const std::string part = "weave fx/labels.nrrd --label 2 -o part.t4d --region ";
  const Finished cut = run(part + ":,8:,:,1:4 --json");
  ASSERT_EQ(cut.exitCode, 0) << cut.err;
  EXPECT_EQ(cut.value()["frames"], 3);
  EXPECT_THAT(cut.err, testing::HasSubstr("is closed there: at y = 8"));
  const json info = run("info part.t4d --json").value();
  EXPECT_EQ(info["details"]["parameters"]["region"], ":,8:,:,1:4");
  refuses(part + ":,:,:,1:99", "labels.nrrd: the region has 1:99 along t, where there are");
  for (const std::string wrong : {":,:", "4:4,:,:", "a:,:,:"}) {
    EXPECT_EQ(run(part + wrong).exitCode, 2) << wrong;
  }
  EXPECT_EQ(run("weave fx/bending_*.obj --voxel-size 1 --region :,:,: -o out.t4d").exitCode, 2);
}

TEST_F(Program, AFolderOfFramesHasItsNameHoweverItIsWritten) {
  ASSERT_EQ(
      run("voxelize fx/cube.obj -m fx/rest.json --voxel-size 4 --frames 2 -o frames/").exitCode, 0);
  for (const char* folder : {"frames", "frames/", "./frames/.", "fx/../frames"}) {
    ASSERT_EQ(run(std::string("weave ") + folder + " -o woven.t4d").exitCode, 0) << folder;
    const json info = run("info woven.t4d --json").value();
    EXPECT_EQ(info["bodies"][0]["name"], "frames") << folder;
    EXPECT_EQ(info["details"]["source"]["frames"], "frames") << folder;
  }
}

/// labels.nrrd: two balls with labels 1 and 2, and voxels that are no cubes.
TEST_F(Program, VolumesAreWoven) {
  double parts = 0;
  for (const char* label : {"1", "2"}) {
    const std::string output = std::string("ball") + label + ".t4d";
    ASSERT_EQ(run("weave fx/labels.nrrd --label " + std::string(label) + " -o " + output).exitCode,
              0);
    const json report = run("validate " + output + " --json").value();
    EXPECT_TRUE(report["closed"] && report["oriented"]);
    parts += report["hypervolume"].get<double>();
  }
  ASSERT_EQ(run("weave fx/labels.nrrd --label 1 2 -o two.t4d").exitCode, 0);
  const json bodies = run("validate two.t4d --json").value();
  EXPECT_TRUE(bodies["valid"]);
  EXPECT_NEAR(bodies["hypervolume"], parts, 1e-12 * parts);
  EXPECT_EQ(run("info two.t4d --json").value()["bodies"][1]["name"], "label 2");
  // Anything above 0 is both of them.
  ASSERT_EQ(run("weave fx/labels.nrrd --iso 0.5 -o both.t4d").exitCode, 0);
  const json info = run("info both.t4d --json").value();
  EXPECT_EQ(info["time_end"], 0.5);
  EXPECT_EQ(info["length_unit"], "mm");
  EXPECT_EQ(info["time_unit"], "s");
  ASSERT_EQ(
      run("weave fx/labels.nrrd --iso 0.5 --frame-time 1 --spacing 1 --origin 0 0 0 -o unit.t4d")
          .exitCode,
      0);
  refuses("weave fx/labels.nrrd -o out.t4d", "an iso value or a label must be given");
  refuses("weave fx/labels.nrrd --label 7 -o out.t4d", "no sample of any frame is 7");
  write("bare.raw", std::string(16, '\1'));
  refuses("weave bare.raw --frame-time 1 -o out.t4d", "does not begin with a line");
  ASSERT_EQ(run("weave bare.raw --raw 'bool 2 2 2 2' --frame-time 1 -o bare.t4d").exitCode, 0);
  misused("weave fx/labels.nrrd one.vdb --iso 1 -o out.t4d", "are not of one kind");
  misused("weave frames --label 1 -o out.t4d", "--label");
  misused("weave frames --substeps 4 -o out.t4d", "--substeps requires --velocity");
  misused("weave frames --velocity estimate -o out.t4d", "cannot be estimated");
  misused("weave frames --velocity v --between distance -o out.t4d", "--between is for masks");
  misused("weave fx/labels.nrrd --label 1 --velocity-file a.npy b.npy c.npy -o out.t4d",
          "--label makes masks");
  misused("weave frames --velocity-file a.npy b.npy c.npy -o out.t4d", "--velocity GRID");
  misused("weave fx/labels.nrrd --label 1 --velocity v -o out.t4d", "--velocity is for .vdb files");
  misused("weave fx/labels.nrrd --label 99999999999999999999 -o out.t4d", "--label");
  misused("weave fx/labels.nrrd --label 3 3 -o out.t4d", "--label: a label is given twice");
  misused("weave fx/labels.nrrd --axes xxyz -o out.t4d", "is not an order of x, y, z, t and c");
  misused("weave fx/labels.nrrd --spacing 1 2 -o out.t4d", "--spacing is one length, or three");
}

/// However the place of a lattice is given, one too far for doubles is refused, and the file named.
TEST_F(Program, FarVolumesAreRefused) {
  const std::string weave = "weave fx/labels.nrrd --label 1 ";
  ASSERT_EQ(run(weave + "-o near.t4d").exitCode, 0);
  const double expected = run("validate near.t4d --json").value()["hypervolume"];
  ASSERT_EQ(run(weave + "--origin 1e6 -1e7 1e6 -o away.t4d").exitCode, 0);
  EXPECT_NEAR(run("validate away.t4d --json").value()["hypervolume"], expected, 1e-6 * expected);
  for (const char* away : {"1e11", "1e16", "1e17", "1e40"}) {
    for (const std::string& origin : {std::string(away) + " 0 0", "0 0 -" + std::string(away)}) {
      refuses(weave + "--origin " + origin + " -o out.t4d", "fx/labels.nrrd: frame 0: lies up to");
    }
  }
  refuses(weave + "--spacing 1e-12 -o out.t4d", "voxels from the origin of space");
  refuses(weave + "--spacing 1e-80 --origin 0 0 0 -o out.t4d", "fx/labels.nrrd");
  refuses("weave fx/cube.obj fx/cube.obj --voxel-size 1e-9 -o out.t4d", "fx/cube.obj");
}

TEST_F(Program, VolumesOfPatientsSayWhereTheAxesPoint) {
  const auto withSpace = [&](const std::string& space, const std::string& name) {
    std::string header = "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 3 3 3 2\n";
    if (!space.empty()) header += "space: " + space + "\n";
    header += "space directions: (1,0,0) (0,1,0) (0,0,2) none\nencoding: text\n\n";
    for (int i = 0; i < 54; ++i) header += i % 27 == 13 ? "1 " : "0 ";
    write(name, header);
  };
  withSpace("LPS", "brain.nrrd");
  withSpace("left-anterior-superior", "las.nrrd");
  withSpace("", "none.nrrd");
  const auto woven = [&](const std::string& name, const std::string& options = "") {
    return run("weave " + name + " --label 1 -o out.t4d " + options);
  };
  EXPECT_THAT(woven("brain.nrrd").out,
              testing::HasSubstr("positions are LPS: x to the left, y posterior, z superior"));
  EXPECT_EQ(run("info out.t4d --json").value()["up"], "z");
  EXPECT_EQ(run("info out.t4d --json").value()["bodies"][0]["name"], "brain");
  EXPECT_THAT(contents(folder_ / "out.t4d"), testing::HasSubstr(R"("space": "LPS")"));
  EXPECT_EQ(woven("brain.nrrd", "--up y --json").value()["space"], "LPS");
  EXPECT_EQ(run("info out.t4d --json").value()["up"], "y");
  EXPECT_THAT(woven("las.nrrd").err, testing::HasSubstr("x is negated"));
  EXPECT_THAT(contents(folder_ / "out.t4d"), testing::HasSubstr(R"("space": "RAS")"));
  EXPECT_EQ(woven("none.nrrd", "--json").value()["space"], nullptr);
  EXPECT_EQ(run("info out.t4d --json").value()["up"], "y");
  EXPECT_THAT(woven("none.nrrd").err,
              testing::HasSubstr("frames are taken to be 1 apart; --frame-time or --times"));
  EXPECT_EQ(woven("none.nrrd", "--frame-time 2").err, "");
  EXPECT_THAT(contents(folder_ / "out.t4d"), testing::Not(testing::HasSubstr("\"space\"")));
}

TEST_F(Program, BodiesAreNamedWithoutAllExtensions) {
  ASSERT_EQ(run("weave fx/labels.nrrd --label 1 -o labels.t4d").exitCode, 0);
  // A header of 352 bytes, three axes, bytes: see the tests of volumes.
  std::string nifti(352, '\0');
  const auto put = [&](std::size_t at, std::string bytes) {
    nifti.replace(at, bytes.size(), bytes);
  };
  put(0, {"\x5C\1\0\0", 4});
  put(40, {"\4\0\3\0\3\0\3\0\2\0", 10});
  put(70, {"\2\0\x8\0", 4});
  for (const std::size_t at : {80, 84, 88, 92}) put(at, {"\0\0\x80\x3F", 4});
  put(108, {"\0\0\xB0\x43", 4});
  put(344, "n+1");
  for (int i = 0; i < 54; ++i) nifti += i % 27 == 13 ? '\1' : '\0';
  write("brain.nii", nifti);
  write("a.b.nii", nifti);
  ASSERT_EQ(shell("gzip -k brain.nii && cp brain.nii.gz a.tar.nii.gz && cp brain.nii.gz T.NII.GZ"),
            0);
  for (const auto& [file, name] : std::map<std::string, std::string>{{"brain.nii", "brain"},
                                                                     {"brain.nii.gz", "brain"},
                                                                     {"a.b.nii", "a.b"},
                                                                     {"a.tar.nii.gz", "a.tar"},
                                                                     {"T.NII.GZ", "T"}}) {
    ASSERT_EQ(run("weave " + file + " --label 1 -o out.t4d").exitCode, 0) << file;
    EXPECT_EQ(run("info out.t4d --json").value()["bodies"][0]["name"], name);
  }
  fs::remove(folder_ / "out.t4d");
  refuses("slice brain.nii.gz --time 0", "t4d weave brain.nii.gz -o brain.t4d");
}

TEST_F(Program, MeshesOfAnyTrianglesAreWoven) {
  // A ball of radius 4 that moves by less than a voxel between frames, with other triangles in
  // each.
  constexpr int kFrames = 11;
  fs::create_directory(folder_ / "by-hand");
  for (int i = 0; i < kFrames; ++i) {
    const std::string name = "ball_" + std::to_string(i);
    write(name + ".obj", ballText(4, 0.4 * i, 60 + 7 * i, 40 + 3 * (i % 4)));
    ASSERT_EQ(
        run("voxelize " + name + ".obj -m fx/rest.json --voxel-size 0.5 --frames 2 -o " + name)
            .exitCode,
        0);
    fs::copy(folder_ / name / "frame_0000.vdb", folder_ / "by-hand" / (name + ".vdb"));
  }
  const Finished done =
      run("weave ball_*.obj --voxel-size 0.5 --frame-time 0.25 -o balls.t4d --json");
  EXPECT_EQ(done.value()["frames"], kFrames);
  EXPECT_EQ(done.err,
            "t4d: note: frames are in the order of the numbers in their names, from ball_0.obj to "
            "ball_10.obj\n");
  const json report = run("validate balls.t4d --deep --json").value();
  EXPECT_TRUE(report["valid"] && report["closed"] && report["oriented"]);
  // The meshes have up to 0.4 % less than the ball, voxels change 1 %.
  const double ball = 4 * std::acos(-1.0) / 3 * 64;
  EXPECT_NEAR(report["hypervolume"], 2.5 * ball, 0.015 * 2.5 * ball);
  const json info = run("info balls.t4d --json").value();
  EXPECT_EQ(info["time_end"], 2.5);
  EXPECT_EQ(info["details"]["parameters"]["voxel_size"], 0.5);
  EXPECT_EQ(info["details"]["source"]["meshes"], kFrames);
  // Grids made by hand give the same mesh.
  ASSERT_EQ(run("weave by-hand --frame-time 0.25 --body ball_0 -o by-hand.t4d").exitCode, 0);
  const json same = run("diff balls.t4d by-hand.t4d --json").value();
  EXPECT_THAT(same["level"], testing::AnyOf("bytes", "mesh"));

  const std::string first = "weave ball_0.obj ";
  EXPECT_THAT(run(first + "ball_1.obj --voxel-size 1 -o unit.t4d").err,
              testing::HasSubstr("frames are taken to be 1 apart"));
  misused(first + "ball_1.obj -o out.t4d", "need --voxel-size");
  misused(first + "by-hand/ball_1.vdb --voxel-size 1 -o out.t4d", "are not of one kind");
  misused(first + "ball_1.obj --voxel-size 1 --iso 1 -o out.t4d", "not for triangle meshes");
  misused("weave by-hand --voxel-size 1 -o out.t4d", "--voxel-size is for triangle meshes");
  refuses(first + "--voxel-size 1 -o out.t4d", "ball_0.obj: one frame only");
  refuses(first + "ball_2.obj --voxel-size 1 -o out.t4d", "number 1 is missing");
  const std::string text = contents(folder_ / "ball_1.obj");
  write("ball_1.obj", text.substr(0, text.rfind("f ")));
  refuses(first + "ball_1.obj --voxel-size 1 -o out.t4d", "ball_1.obj: the mesh is open");
  write("ball_1.obj", "v 0 0 nan\n" + text);
  refuses(first + "ball_1.obj --voxel-size 1 -o out.t4d", "ball_1.obj:1: ");
  write("ball_1.obj", text + "f 1 3 2\n");
  refuses(first + "ball_1.obj --voxel-size 1 -o out.t4d", "ball_1.obj: ");
  EXPECT_THAT(run("weave ball_2.obj ball_3.obj --voxel-size 20 --frame-time 1 -o wide.t4d").err,
              testing::HasSubstr("larger than the solid of ball_2.obj"));
}

/// A cube of `size` voxels on a side, one frame of 6 x 6 x 6 bytes of 9 in 1.
std::string cubeFrame(int size) {
  std::string text = "raw uint8 6 6 6 little\n";
  for (int i = 0; i < 216; ++i) {
    const bool inside = i % 6 < size && i / 6 % 6 < size && i / 36 < size;
    text += inside ? '\x09' : '\1';
  }
  return text;
}

TEST_F(Program, FramesAreWovenInTheOrderGiven) {
  write("before.raw", cubeFrame(2));
  write("after.raw", cubeFrame(4));
  const auto volumes = [&](const std::string& frames) {
    EXPECT_EQ(run("weave " + frames + " --iso 5 --spacing 1 --frame-time 1 -o out.t4d").exitCode,
              0);
    const json samples = run("measure out.t4d --frames 2 --json").value()["samples"];
    return samples[0]["volume"].get<double>() < samples[1]["volume"].get<double>();
  };
  EXPECT_TRUE(volumes("before.raw after.raw"));
  EXPECT_FALSE(volumes("after.raw before.raw"));
  // A shell sorts what a pattern matches by text.
  for (const int i : {1, 2, 10}) write("f" + std::to_string(i) + ".raw", cubeFrame(1 + i % 5));
  const std::string weave = " --iso 5 --spacing 1 --frame-time 1 --caps graded -o out.t4d";
  const Finished sorted = run("weave f*.raw" + weave);
  EXPECT_EQ(sorted.err,
            "t4d: note: frames are in the order of the numbers in their names, from f1.raw to "
            "f10.raw\n");
  const Finished ordered = run("weave f1.raw f2.raw f10.raw" + weave);
  EXPECT_EQ(ordered.err, "");
  EXPECT_EQ(run("weave f10.raw f1.raw f2.raw" + weave).err,
            "t4d: note: frames are in the order given, from f10.raw to f2.raw, which is not that "
            "of the numbers in their names\n");
  EXPECT_THAT(run("weave f10.raw f2.raw" + weave).err, testing::HasSubstr("in the order given"));
  // A folder has no order but that of names, unless its files have times.
  ASSERT_EQ(run("voxelize fx/cube.obj -m fx/rest.json --voxel-size 4 --frames 2 -o grids").exitCode,
            0);
  EXPECT_EQ(run("weave grids --caps graded -o out.t4d").err, "");
  EXPECT_THAT(run("weave grids --frame-time 2 -o out.t4d").err,
              testing::HasSubstr("from grids/frame_0000.vdb to grids/frame_0001.vdb"));
}

TEST_F(Program, TimesOfFramesAreGivenOneByOne) {
  for (const int i : {1, 2, 3}) write("f" + std::to_string(i) + ".raw", cubeFrame(i));
  const std::string weave = "weave f1.raw f2.raw f3.raw --iso 5 --spacing 1 -o out.t4d ";
  ASSERT_EQ(run(weave + "--times 0,34,90").exitCode, 0);
  // A time and the one of a frame: the slice is that frame.
  const json samples = run("measure out.t4d --times 0,34,90 --json").value()["samples"];
  ASSERT_EQ(samples.size(), 3U);
  EXPECT_EQ(samples[1]["time"], 34);
  EXPECT_EQ(samples[2]["max"], json::parse("[2.5, 2.5, 2.5]"));
  EXPECT_EQ(run(weave + "--times 5:9:3").exitCode, 0);
  EXPECT_EQ(run("info out.t4d --json").value()["time_begin"], 5);
  fs::remove(folder_ / "out.t4d");
  refuses(weave + "--times 0,34", "f1.raw: 2 times for 3 frames: expected one for each");
  refuses(weave + "--times 0,34,30", "times do not increase");
  misused(weave + "--times 0,x", "--times: '0,x' is neither A:B:N, with N from 1 to");
  EXPECT_EQ(run(weave + "--times 0,1,2 --frame-time 1").exitCode, 2);
  ASSERT_EQ(run("voxelize fx/cube.obj -m fx/rest.json --voxel-size 4 --frames 2 -o grids").exitCode,
            0);
  ASSERT_EQ(run("weave grids --times 3,7 -o out.t4d").exitCode, 0);
  EXPECT_EQ(run("info out.t4d --json").value()["time_end"], 7);
  ASSERT_EQ(
      run("weave fx/bending_0.obj fx/bending_4.obj --voxel-size 1 --times 0,4 -o out.t4d").exitCode,
      0);
  EXPECT_EQ(run("info out.t4d --json").value()["time_end"], 4);
}

TEST_F(Program, WhatIsInsideAndOutsideIsSaid) {
  // 9 in 1 is 1 in 9 below a value, and 255 is no data in both.
  std::string hill = "raw uint8 6 6 6 2 little\n";
  std::string bowl = hill;
  for (int frame = 0; frame < 2; ++frame) {
    for (const char sample : cubeFrame(3).substr(23)) {
      hill += sample;
      bowl += static_cast<char>(10 - sample);
    }
  }
  write("hill.raw", hill);
  write("bowl.raw", bowl);
  hill.back() = '\xFF';
  write("padded.raw", hill);
  const auto hypervolume = [&](const std::string& options) {
    EXPECT_EQ(run("weave " + options + " -o out.t4d").exitCode, 0) << options;
    return run("validate out.t4d --json").value()["hypervolume"].get<double>();
  };
  const double expected = hypervolume("hill.raw --iso 5");
  EXPECT_EQ(hypervolume("bowl.raw --below 5"), expected);
  EXPECT_EQ(run("info out.t4d --json").value()["details"]["parameters"]["below"], 5);
  EXPECT_NE(hypervolume("padded.raw --iso 5"), expected);
  EXPECT_EQ(hypervolume("padded.raw --iso 5 --outside-value 255"), expected);
  EXPECT_EQ(run("info out.t4d --json").value()["details"]["parameters"]["outside_value"], 255);
  fs::remove(folder_ / "out.t4d");
  EXPECT_EQ(run("weave hill.raw --iso 5 --below 5 -o out.t4d").exitCode, 2);
  misused("weave hill.raw --label 9 --below 5 -o out.t4d",
          "--label and --below exclude each other");
  misused("weave hill.raw --label 9 --outside-value 5 -o out.t4d", "exclude each other");
  misused("weave hill.raw --iso 5 --outside-value x -o out.t4d", "is neither a number nor nan");
  EXPECT_EQ(run("weave hill.raw --iso 5 --outside-value nan -o out.t4d").exitCode, 0);
  const std::string said = run("weave hill.raw --iso 5 -o out.t4d").err;
  EXPECT_THAT(said, testing::HasSubstr("nothing says how large the voxels are: they are taken as "
                                       "1; --spacing changes that"));
  EXPECT_THAT(said, testing::HasSubstr("frames are taken to be 1 apart"));
  EXPECT_EQ(run("weave hill.raw --iso 5 --spacing 1 --frame-time 1 --caps graded -o out.t4d").err,
            "");
}

TEST_F(Program, EveryLabelBecomesABody) {
  const Finished all = run("weave fx/labels.nrrd --label all -o all.t4d");
  ASSERT_EQ(all.exitCode, 0) << all.err;
  EXPECT_THAT(all.err,
              testing::HasSubstr("found 2 labels, each a body: 1, 2; 0 is the background"));
  ASSERT_EQ(run("weave fx/labels.nrrd --label 1 2 -o two.t4d").exitCode, 0);
  EXPECT_EQ(contents(folder_ / "all.t4d"), contents(folder_ / "two.t4d"));
  misused("weave fx/labels.nrrd --label all 2 -o out.t4d", "--label: 'all' is given alone");
  misused("weave fx/labels.nrrd --label some -o out.t4d", "is neither a whole number of 64 bits");
  refuses("weave fx/labels.nrrd --region :,:1,:1 --label all -o out.t4d", "has no label");
}

/// One table for all bodies, each at each time; the sum is in the JSON, too.
TEST_F(Program, BodiesAreMeasuredInOneTable) {
  ASSERT_EQ(run("weave fx/labels.nrrd --label all -o two.t4d").exitCode, 0);
  const json both = run("measure two.t4d --frames 3 --json").value();
  EXPECT_EQ(both["length_unit"], "mm");
  EXPECT_EQ(both["time_unit"], "s");
  for (const json& sample : both["samples"]) {
    double volume = 0;
    for (const json& body : sample["bodies"]) volume += body["volume"].get<double>();
    EXPECT_DOUBLE_EQ(sample["volume"], volume);
  }
  EXPECT_EQ(both["samples"][0]["bodies"][1]["name"], "label 2");
  const json second = run("measure two.t4d --body 'label 2' --frames 3 --json").value();
  EXPECT_FALSE(second["samples"][0].contains("bodies"));
  EXPECT_EQ(second["samples"][1]["volume"], both["samples"][1]["bodies"][1]["volume"]);
  ASSERT_EQ(run("measure two.t4d --frames 3 -o each.csv").exitCode, 0);
  const std::string each = contents(folder_ / "each.csv");
  EXPECT_TRUE(each.starts_with("time,body,volume,area,cx,"));
  EXPECT_EQ(std::ranges::count(each, '\n'), 7);
  EXPECT_THAT(each, testing::HasSubstr("\n0.25,label 2,"));
  EXPECT_THAT(each, testing::HasSubstr(",mm,s\n"));
  ASSERT_EQ(run("measure two.t4d --frames 3 --total -o total.csv").exitCode, 0);
  const std::string total = contents(folder_ / "total.csv");
  EXPECT_TRUE(total.starts_with("time,volume,area,cx,"));
  EXPECT_EQ(std::ranges::count(total, '\n'), 4);
  EXPECT_FALSE(
      run("measure two.t4d --frames 3 --total --json").value()["samples"][0].contains("bodies"));
  EXPECT_THAT(run("measure two.t4d --frames 2").out, testing::HasSubstr("label 1"));
}

TEST_F(Program, BadFramesAreRefused) {
  ASSERT_EQ(run("voxelize fx/cube.obj -m fx/rest.json --voxel-size 1 --frames 2 -o two").exitCode,
            0);
  fs::create_directories(folder_ / "none");
  fs::create_directories(folder_ / "one");
  fs::copy_file(folder_ / "two" / "frame_0000.vdb", folder_ / "one" / "frame_0000.vdb");
  const std::string whole = contents(folder_ / "two" / "frame_0001.vdb");
  write("cut.vdb", whole.substr(0, whole.size() / 2));
  const std::string first = "weave two/frame_0000.vdb ";
  refuses("weave none -o out.t4d", "none");
  refuses("weave one -o out.t4d", "one frame only");
  misused("weave fx/cube.obj fx/torus.obj -o out.t4d", "need --voxel-size");
  refuses(first + "cut.vdb -o out.t4d", "cut.vdb");
  refuses(first + "two/frame_0000.vdb -o out.t4d", "times do not increase");
  refuses("weave two --iso 1000 -o out.t4d", "1000");
  const std::string voxels = "sweep fx/cube.obj -m fx/rest.json --backend voxel4d -o out.t4d ";
  misused(voxels + "--voxel-size 0 --frames 3", "--voxel-size: '0' is not a number above 0");
  misused(voxels + "--voxel-size 1 --frames 1", "--frames: '1'");
  misused(voxels + "--voxel-size 1 --frame-time inf", "--frame-time: 'inf'");
  misused("voxelize fx/cube.obj -m fx/rest.json --voxel-size 1 --frames 1 -o out", "--frames: '1'");
}

}  // namespace
}  // namespace t4d::tools
