#include <cmath>
#include <set>
#include <string>

#include <gmock/gmock.h>

#include "tools/t4d/tests/program.h"

/// `t4d convert` and `formats`.
namespace t4d::tools {
namespace {

TEST_F(Program, FormatsListsEachOnceWithWhatItKeeps) {
  std::set<std::string> ids;
  std::set<std::string> names;
  const json formats = run("formats --json").value()["formats"];
  for (const json& format : formats) {
    const auto name = format["name"].get<std::string>();
    const auto id = format["id"].get<std::string>();
    EXPECT_TRUE(format["reads"] || format["writes"]) << name;
    EXPECT_FALSE(format["keeps"].empty()) << name;
    EXPECT_FALSE(format["extensions"].empty()) << name;
    EXPECT_TRUE(id.empty() || ids.insert(id).second) << id;
    EXPECT_TRUE(names.insert(name).second) << name;
  }
}

TEST_F(Program, ConvertGivesTheSameSolidBackFromEachFormat) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  const json whole = run("validate cube.t4d --json").value();
  ASSERT_EQ(run("slice cube.t4d --time 20.3 -o before.ply").exitCode, 0);
  const json formats = run("formats --json").value()["formats"];
  int converted = 0;
  for (const json& format : formats) {
    if (format["kind"] != "4D mesh" || !format["reads"] || format["id"] == "t4d") continue;
    if (format["extensions"][0] == ".t4dm") continue;  // join writes it
    ++converted;
    const std::string there = "there" + format["extensions"][0].get<std::string>();
    const std::string to = " --to " + format["id"].get<std::string>();
    const Finished lossy = run("convert cube.t4d " + there + to + " --json");
    EXPECT_EQ(lossy.exitCode, 3) << there;
    EXPECT_GE(lossy.value()["losses"].size(), 1U);
    EXPECT_EQ(lossy.value()["out"]["format"], format["id"]);
    EXPECT_EQ(run("convert cube.t4d " + there + to + " --accept-loss").exitCode, 0);
    const Finished back = run("convert " + there + " back.t4d --json");
    ASSERT_EQ(back.exitCode, 0) << back.err;
    EXPECT_EQ(back.value()["in"]["format"], format["id"]);
    EXPECT_EQ(back.value()["vertices"], 4750);
    EXPECT_EQ(back.value()["tetrahedra"], 21552);
    const json again = run("validate back.t4d --json").value();
    for (const char* same : {"valid", "closed", "oriented", "components", "degenerate_cells"}) {
      EXPECT_EQ(again[same], whole[same]) << there << " " << same;
    }
    EXPECT_NEAR(again["hypervolume"].get<double>(), whole["hypervolume"].get<double>(), 1e-6);
    const json slice = run("slice back.t4d --time 20.3 --json").value();
    EXPECT_TRUE(slice["closed"]);
    EXPECT_NEAR(slice["volume"].get<double>(), 8000, 1e-6);
  }
  EXPECT_GE(converted, 7);
}

TEST_F(Program, ConvertMendsCutsAndRefuses) {
  const auto hypervolume = [&](const std::string& file) {
    return run("validate " + file + " --json").value()["hypervolume"].get<double>();
  };
  ASSERT_EQ(run("convert fx/24-cell.off whole.t4d").exitCode, 0);
  EXPECT_NEAR(hypervolume("whole.t4d"), 8, 1e-12);
  ASSERT_EQ(run("convert fx/600-cell.off cut.t4d --slabs 5").exitCode, 0);
  EXPECT_EQ(run("info cut.t4d --json").value()["slabs"], 5);
  const double golden = (1 + std::sqrt(5)) / 2;
  EXPECT_NEAR(hypervolume("cut.t4d"),
              150 * std::sqrt((4 + 6 * golden) / 16) / (6 * std::sqrt(2) * std::pow(golden, 3)),
              1e-12);
  // The mesh loses its last tetrahedron.
  ASSERT_EQ(run("convert fx/16-cell.off whole.off --to off-ijk").exitCode, 0);
  ASSERT_EQ(shell("sed -e 's/^8 16 0/8 15 0/' -e '$d' whole.off > open.off"), 0);
  refuses("convert open.off no.t4d",
          "is not closed: 4 of its triangles do not have two tetrahedra");
  refuses("convert open.off no.t4d", "--allow-open");
  const Finished open = run("convert open.off open.t4d --allow-open --json");
  EXPECT_EQ(open.exitCode, 0);
  EXPECT_FALSE(open.value()["closed"]);
  EXPECT_TRUE(run("validate open.t4d --json").value()["hypervolume"].is_null());
  refuses("convert open.t4d no.off", "--allow-open");
  refuses("convert whole.off whole.off", "is an input of this run", 2);
  refuses("convert whole.off out.xyz", "unsupported output extension", 2);
  refuses("convert whole.off out.t4d --from medit", "whole.off");
  refuses("convert fx/cube.obj out.t4d", "is not a 4D mesh in a known format");
  refuses("convert fx/labels.nrrd out.t4d", "t4d weave fx/labels.nrrd");
  refuses("convert whole.off out.t4d --weld -1", "--weld: '-1' is not a number from 0 on", 2);
  refuses("slice whole.off --time 0", "t4d convert whole.off whole");
}

TEST_F(Program, ConvertListsWhatAnotherFormatDoesNotKeepOfAFile) {
  ASSERT_EQ(run("sweep fx/cube.obj -m fx/rest.json --caps cone -o cube.t4d").exitCode, 0);
  const auto lossOf = [&](const std::string& file) {
    const auto done = run("convert " + file + " out.vtu");
    EXPECT_EQ(done.exitCode, 3);
    return done.err;
  };
  EXPECT_THAT(lossOf("cube.t4d"),
              testing::HasSubstr("metadata not kept by vtu: how the mesh was made\n"));
  ASSERT_EQ(run("transform cube.t4d --space RAS -o patient.t4d").exitCode, 0);
  EXPECT_THAT(lossOf("patient.t4d"),
              testing::HasSubstr("the anatomical space not kept by vtu: RAS\n"));
}

TEST_F(Program, ConvertNotesChoicesThatMayBeMistakes) {
  const auto notes = [&](const std::string& arguments) { return run("convert " + arguments).err; };
  EXPECT_THAT(
      notes("fx/16-cell.off a.t4d --slabs 9"),
      testing::HasSubstr("cut into 2 slabs, not 9: its vertices have only 3 different times"));
  EXPECT_THAT(notes("fx/600-cell.off a.vtu --slabs 2"), testing::HasSubstr("has no slabs"));
  misused("convert fx/16-cell.off a.vtu --to gmsh", "'a.vtu' does not end with .msh, as gmsh does");
  misused("convert fx/16-cell.off scan.nii.gz --to t4d", "does not end with .t4d, as t4d does");
  EXPECT_THAT(notes("fx/16-cell.off b.off --to off-ijk"), testing::Not(testing::HasSubstr("--to")));
}

}  // namespace
}  // namespace t4d::tools
