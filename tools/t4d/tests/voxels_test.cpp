#include <string>

#include <gmock/gmock.h>

#include "tools/t4d/tests/program.h"

/// The backend voxel4d: `t4d voxelize` and `rasterize`, and the sweeps and weaves that go with
/// them.
namespace t4d::tools {
namespace {

TEST_F(Program, SmallVoxelsWorkByFilesAndWithout) {
  placeFixture("cube", 1e-4, 0);
  ASSERT_EQ(run("sweep cube-placed.obj -m fx/rest.json --backend voxel4d --voxel-size 2e-4 "
                "--frames 2 -o a.t4d")
                .exitCode,
            0);
  const std::string voxelize =
      "voxelize cube-placed.obj -m fx/rest.json --voxel-size 2e-4 --frames 2 -o ";
  ASSERT_EQ(run(voxelize + "frames").exitCode, 0);
  ASSERT_EQ(run("weave frames -o b.t4d").exitCode, 0);
  const json a = run("validate a.t4d --json").value();
  const json b = run("validate b.t4d --json").value();
  EXPECT_EQ(a["valid"], true);
  EXPECT_EQ(a["hypervolume"], b["hypervolume"]);
  EXPECT_NEAR(a["hypervolume"].get<double>() / (8e-9 * 10), 1, 0.2);
  // The same input makes the same bytes.
  ASSERT_EQ(run(voxelize + "again").exitCode, 0);
  for (const char* name : {"frame_0000.vdb", "frame_0001.vdb"}) {
    EXPECT_EQ(contents(folder_ / "frames" / name), contents(folder_ / "again" / name));
  }
}

TEST_F(Program, VoxelsThatOpenVdbTakesForNoneWorkWithoutFiles) {
  placeFixture("cube", 1e-6, 0);
  ASSERT_EQ(run("sweep cube-placed.obj -m fx/rest.json --backend voxel4d --voxel-size 2e-6 "
                "--frames 2 -o a.t4d")
                .exitCode,
            0);
  const json a = run("validate a.t4d --json").value();
  EXPECT_NEAR(a["hypervolume"].get<double>() / (8e-15 * 10), 1, 0.2);
  refuses("voxelize cube-placed.obj -m fx/rest.json --voxel-size 2e-6 --frames 2 -o frames",
          "scale the solid");
}

TEST_F(Program, EmptyResultsHaveANote) {
  write("nowhere.obj",
        "v 0.3 0.3 0.3\nv 0.6 0.3 0.3\nv 0.3 0.6 0.3\nv 0.3 0.3 0.6\n"
        "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
  const Finished done =
      run("voxelize nowhere.obj -m fx/rest.json --voxel-size 1 --frames 2 -o frames");
  EXPECT_EQ(done.exitCode, 0);
  EXPECT_NE(done.err.find("voxels of 1 are larger than the solid"), std::string::npos) << done.err;
  EXPECT_NE(done.err.find("2 of 2 frames have no point inside"), std::string::npos) << done.err;
}

TEST_F(Program, FramesMayBeLeftOut) {
  const std::string turn = " -m fx/paper-translation.json --voxel-size 4 ";
  const json series = run("voxelize fx/paper-cube.obj" + turn + "-o frames --json").value();
  EXPECT_EQ(series["frames"], 17);
  const Finished swept =
      run("sweep fx/paper-cube.obj --backend voxel4d" + turn + "-o all.t4d --json");
  EXPECT_EQ(swept.value()["steps"], 16);
  EXPECT_EQ(swept.err, "");
  const Finished few =
      run("sweep fx/paper-cube.obj --backend voxel4d" + turn + "--frames 5 -o few.t4d");
  EXPECT_THAT(few.err, testing::HasSubstr("points move up to 4 voxels between two frames; 17 "
                                          "frames over the whole motion would keep them"));
  EXPECT_EQ(few.exitCode, 0);
  refuses("voxelize fx/cube.obj -m fx/paper-translation.json --voxel-size 1e-6 -o out",
          "at most 1000000 are allowed; use larger voxels, or choose the number of frames");
}

/// Section 5.1, the voxel method.
TEST_F(Program, PaperVoxelCubeByWayOfFiles) {
  ASSERT_EQ(run("voxelize fx/paper-cube.obj -m fx/paper-voxel.json --voxel-size 1 --frames 64 "
                "--mask -o frames")
                .exitCode,
            0);
  const json woven = run("weave frames -o woven.t4d --json").value();
  EXPECT_EQ(woven["vertices"], 197828);
  EXPECT_EQ(woven["tetrahedra"], 1185280);
  EXPECT_EQ(woven["frames"], 64);
  EXPECT_TRUE(woven.contains("seconds") && woven.contains("peak_bytes"));
  const json valid = run("validate woven.t4d --json").value();
  EXPECT_EQ(valid["valid"], true);
  EXPECT_EQ(valid["closed"], true);
  EXPECT_EQ(run("info woven.t4d --json").value()["backend"], "voxel4d");
  const json direct = run("sweep fx/paper-cube.obj -m fx/paper-voxel.json --backend voxel4d "
                          "--voxel-size 1 --frames 64 --mask -o direct.t4d --json")
                          .value();
  EXPECT_EQ(direct["vertices"], 197828);
  EXPECT_EQ(direct["tetrahedra"], 1185280);
}

TEST_F(Program, GradedCapsHaveFewerCellsAndTheSameSlices) {
  const std::string sweep =
      "sweep fx/icosphere.obj -m fx/rest.json --backend voxel4d --voxel-size 0.25 --frames 2 ";
  const Finished flat = run(sweep + "-o flat.t4d --json");
  const Finished graded = run(sweep + "--caps graded -o graded.t4d --json");
  EXPECT_THAT(flat.err, testing::HasSubstr("tetrahedra are in the flat caps; graded caps"));
  EXPECT_EQ(graded.err, "");
  for (const std::size_t end : {0U, 1U}) {
    EXPECT_LT(graded.value()["cap_tetrahedra"][end].get<double>(),
              0.4 * flat.value()["cap_tetrahedra"][end].get<double>());
  }
  EXPECT_EQ(run("validate graded.t4d").exitCode, 0);
  EXPECT_EQ(run("info graded.t4d --json").value()["details"]["parameters"]["caps"], "graded");
  ASSERT_EQ(run("slice flat.t4d --time 3.7 -o flat.stl").exitCode, 0);
  ASSERT_EQ(run("slice graded.t4d --time 3.7 -o graded.stl").exitCode, 0);
  EXPECT_EQ(contents(folder_ / "flat.stl"), contents(folder_ / "graded.stl"));
}

TEST_F(Program, GridsToMeshToGridsKeepsTheVolume) {
  const std::string motion = " -m fx/skew-axis.json --voxel-size 0.5 --frames 9 ";
  ASSERT_EQ(run("sweep fx/torus.obj --backend voxel4d" + motion + "-o a.t4d").exitCode, 0);
  ASSERT_EQ(run("rasterize a.t4d --voxel-size 0.5 --frames 9 -o frames").exitCode, 0);
  ASSERT_EQ(run("weave frames -o b.t4d").exitCode, 0);
  const double end = run("info a.t4d --json").value()["time_end"];
  for (const double time : {0.0, 0.3 * end, end}) {
    const std::string at = " --json --time " + std::to_string(time);
    const double a = run("slice a.t4d" + at).value()["volume"];
    const double b = run("slice b.t4d" + at).value()["volume"];
    EXPECT_NEAR(a, b, 0.05 * a);
  }
}

TEST_F(Program, MemoryDoesNotGrowWithTheFrames) {
  const auto peak = [&](const std::string& frames) {
    return run("sweep fx/icosphere.obj -m fx/paper-screw.json --backend voxel4d --voxel-size 0.5 "
               "--threads 1 -o m.t4d --json --frames " +
               frames)
        .value()["peak_bytes"]
        .get<double>();
  };
  EXPECT_LT(peak("200"), 1.15 * peak("20"));
}

}  // namespace
}  // namespace t4d::tools
