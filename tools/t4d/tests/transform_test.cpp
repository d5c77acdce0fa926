#include <filesystem>
#include <string>
#include <utility>

#include "tools/t4d/tests/program.h"

/// `t4d transform`, `filter`, `compress` and `diff`.
namespace t4d::tools {
namespace {

/// Transforms one or several bodies, and checks what a transformed mesh encloses.
TEST_F(Program, TransformsKeepWhatAMeshIs) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  const double hypervolume = run("validate cube.t4d --json").value()["hypervolume"];
  const auto moved = [&](const std::string& options) {
    const json done = run("transform cube.t4d -o moved.t4d --json " + options).value();
    const json report = run("validate moved.t4d --json").value();
    EXPECT_TRUE(report["valid"]) << options;
    EXPECT_LT(fs::file_size(folder_ / "moved.t4d"), 2 * fs::file_size(folder_ / "cube.t4d"));
    return std::pair(done, report["hypervolume"].get<double>() / hypervolume);
  };
  EXPECT_NEAR(moved("--rotate 1 2 3 40 --move 1 2 3").second, 1, 1e-12);
  EXPECT_NEAR(moved("--scale 2 3 -0.5 --time-scale 4").second, 12, 1e-11);
  const auto [done, ratio] =
      moved("--axes y-xz --matrix 1 1 0 5 0 1 0 0 0 0 2 0 --time-shift 7.25");
  EXPECT_NEAR(ratio, 2, 1e-12);
  EXPECT_EQ(done["matrix"], json::array({-1., 1., 0., 5., -1., 0., 0., 0., 0., 0., 2., 0.}));
  EXPECT_EQ(run("info moved.t4d --json").value()["time_begin"], 7.25);
  EXPECT_NEAR(moved("--rotate 1e200 0 0 90").second, 1, 1e-12);
  // The cube moves along z by one in each unit of time: backward, and with z and t exchanged.
  EXPECT_EQ(run("transform cube.t4d --axes xyz-t -o back.t4d").exitCode, 3);
  EXPECT_NEAR(run("validate back.t4d --json").value()["hypervolume"], 512000, 1e-6);
  EXPECT_NEAR(run("slice back.t4d --time -3.25 --json").value()["volume"], 8000, 1e-8);
  EXPECT_EQ(run("transform cube.t4d --axes xytz -o turned.t4d").exitCode, 3);
  EXPECT_TRUE(run("validate turned.t4d --json").value()["valid"]);
  EXPECT_NEAR(run("slice turned.t4d --time 30.7 --json").value()["volume"], 8000, 1e-8);
  refuses("transform cube.t4d --move 1e17 0 0 -o out.t4d", "doubles are too coarse there");
  refuses("transform cube.t4d --time-shift 1e17 -o out.t4d", "both become");
  placeFixture("cube", 1, 1000);
  ASSERT_EQ(run("sweep cube-placed.obj -m fx/rest.json --center -o c.t4d").exitCode, 0);
  const json origin = run("info c.t4d --json").value()["details"]["origin"];
  ASSERT_EQ(run("transform c.t4d --scale 2 -o c2.t4d").exitCode, 0);
  const json doubled = run("info c2.t4d --json").value()["details"]["origin"];
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(doubled[axis].get<double>(), 2 * origin[axis].get<double>());
  }
  misused("transform cube.t4d --axes xxz -o out.t4d", "--axes");
  misused("transform cube.t4d --scale 0 -o out.t4d", "leaves no solid");
  misused("transform cube.t4d --rotate 0 0 0 5 -o out.t4d", "the axis is 0 0 0");
  misused("transform cube.t4d --time-scale -1 -o out.t4d", "--time-scale");
  misused("transform cube.t4d -o cube.t4d", "cube.t4d");
}

TEST_F(Program, PartsOfTheTimeAddUp) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  // The paper's cube moves by one in each unit of time: 8000 is its volume.
  double before = 0;
  for (const double time : {0.7, 2.1, 20.0, 63.999, 64.0}) {
    const json done = run("filter cube.t4d --from " + std::to_string(before) + " --to " +
                          std::to_string(time) + " -o part.t4d --json")
                          .value();
    EXPECT_EQ(done["time_begin"], before);
    EXPECT_EQ(done["time_end"], time);
    const json report = run("validate part.t4d --json").value();
    EXPECT_TRUE(report["valid"]);
    EXPECT_TRUE(report["closed"]);
    EXPECT_NEAR(report["hypervolume"], 8000 * (time - before), 1e-6);
    before = time;
  }
  EXPECT_EQ(run("filter cube.t4d -o whole.t4d").exitCode, 0);
  EXPECT_EQ(run("diff cube.t4d whole.t4d --json").value()["level"], "bytes");
  refuses("filter cube.t4d --from 64 -o out.t4d", "the mesh lasts from time 0 to 64");
  misused("filter cube.t4d --from 2 --to 2 -o out.t4d", "--from 2 is not before --to 2");
  refuses("filter cube.t4d --body paper-cub -o out.t4d", "did you mean paper-cube?");
}

TEST_F(Program, DiffTellsBytesMeshAndSolidApart) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  const auto level = [&](const std::string& other, int exitCode) {
    const Finished done = run("diff cube.t4d " + other + " --json");
    EXPECT_EQ(done.exitCode, exitCode) << done.err;
    return done.value()["level"].get<std::string>();
  };
  EXPECT_EQ(level("cube.t4d", 0), "bytes");
  ASSERT_EQ(run("compress cube.t4d -o small.t4d").exitCode, 0);
  EXPECT_LT(fs::file_size(folder_ / "small.t4d"), fs::file_size(folder_ / "cube.t4d"));
  EXPECT_EQ(level("small.t4d", 0), "mesh");
  ASSERT_EQ(run("compress cube.t4d --grid-step 0.01 -o rounded.t4d").exitCode, 0);
  EXPECT_NE(level("rounded.t4d", 0), "different");
  ASSERT_EQ(run("transform cube.t4d --move 1 0 0 -o moved.t4d").exitCode, 0);
  EXPECT_EQ(level("moved.t4d", 1), "different");
  EXPECT_EQ(level("moved.t4d --tolerance 1.01", 0), "solid");
  refuses("diff cube.t4d fx/cube.obj", "not a .t4d file");
}

}  // namespace
}  // namespace t4d::tools
