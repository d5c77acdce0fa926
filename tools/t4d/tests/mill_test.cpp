#include <string>
#include <vector>

#include "tools/t4d/tests/program.h"

/// `t4d mill`.
namespace t4d::tools {
namespace {

TEST_F(Program, MillSaysWhatItRemovesAndWhatIsWrong) {
  write("slot.nc", "G0 X-16 Y0 Z7\nG1 X16 F600\n");
  const std::string mill = "mill fx/paper-cube.obj --tool flat:d=6,l=30 --gcode slot.nc ";
  const json done =
      run(mill + "--voxel-size 1 --frames 3 --json --html page.html -o out2.t4d").value();
  for (const char* key :
       {"stock_volume", "removed_volume", "remaining_volume", "components", "frames", "progress",
        "separations", "collisions", "returned_volume", "steps", "seconds", "bytes"}) {
    EXPECT_TRUE(done.contains(key)) << key;
  }
  EXPECT_NEAR(done["removed_volume"].get<double>(), 20 * 6 * 3, 25);
  EXPECT_EQ(done["progress"].size(), 3U);
  EXPECT_NE(contents(folder_ / "page.html").find("Removed volume"), std::string::npos);
  const Finished coarse = run(mill + "--voxel-size 7 --frames 3 -o coarse.t4d");
  EXPECT_EQ(coarse.exitCode, 0);
  EXPECT_EQ(coarse.err.find("never meets the stock"), std::string::npos) << coarse.err;
  EXPECT_NE(coarse.err.find("of 8000 as a mesh"), std::string::npos) << coarse.err;
  EXPECT_NE(coarse.err.find("the tool is less than two voxels across"), std::string::npos);
  refuses("mill fx/paper-cube.obj --tool flat:d=1e9,l=30 --gcode slot.nc --voxel-size 1 -o out.t4d",
          "too large for voxels of 1");
  misused(mill + "--voxel-size 1 -o out.t4d --html ./out.t4d", "does not end with .html");
  misused("mill fx/paper-cube.obj --tool foo:d=6,l=30 --gcode slot.nc --voxel-size 1 -o out.t4d",
          "expected ball:, flat:, bull:, drill:, vbit:, chamfer: or taper:");
  misused(
      "mill fx/paper-cube.obj --tool flat:d=6,l=30,q=3 --gcode slot.nc --voxel-size 1 -o out.t4d",
      "--tool: 'q' is not known here");
  misused(mill + "--voxel-size 1 --holder d=40,d=50 -o out.t4d", "--holder: 'd=40,d=50' gives d");
}

TEST_F(Program, MillMountsToolsAndKnowsTheMachine) {
  write("two.nc",
        "G90 T1 M6\nG0 X0 Y0\nG43 H1 Z15\nG1 Z5 F600\nG28 G91 Z0\nG90\nT2 M6\nG55\nG0 X0 Y0\n"
        "G43 H2 Z15\nG81 Z5 R11 F300\nM30\n");
  write("tools.tbl", "T1 P1 Z50 D6 ;flat:d=6,l=30\nT2 P2 Z70 D4\n");
  const std::string mill = "mill fx/paper-cube.obj --gcode two.nc --voxel-size 0.5 --frames 3 ";
  const std::string all = mill + "--tool-table tools.tbl --tool 2=drill:d=4 --offset G55=5,5,0 ";
  const Finished done = run(all + "--json -o mounted.t4d");
  EXPECT_NE(done.err.find("two.nc:5: 1 move goes to places of the machine"), std::string::npos)
      << done.err;
  EXPECT_NE(done.err.find("note: --offset G53=x,y,z gives the machine's zero"), std::string::npos)
      << done.err;
  const json value = done.value();
  std::vector<int> mounted;
  for (const auto& one : value["mountings"]) mounted.push_back(one["tool"]);
  EXPECT_EQ(mounted, (std::vector<int>{1, 0, 2}));
  EXPECT_TRUE(value["collisions"].empty());
  const json stated = run(all + "--offset G53=0,0,200 --json -o mounted.t4d").value();
  EXPECT_NEAR(value["removed_volume"], stated["removed_volume"], 2);
  refuses(mill + "--tool 1=flat:d=6,l=30 --offset G55=5,5,0 -o out.t4d",
          "two.nc:7: tool 2 is mounted, but not given");
  refuses(mill + "--tool 1=flat:d=6,l=30 --tool 2=drill:d=4 -o out.t4d",
          "two.nc:9: G55 is a second origin, after G54");
  refuses(mill + "--tool 1=flat:d=6,l=30 --tool 2=drill:d=4 -o out.t4d",
          "try: --offset ORIGIN=x,y,z");
  misused(mill + "--tool 1=flat:d=6,l=30 --tool flat:d=6,l=30 -o out.t4d",
          "with and without a number");
  misused(mill + "--tool 1=flat:d=6,l=30 --holder 2=d=9,l=9 -o out.t4d", "there is no tool 2");
  misused(all + "--rotary A=table --rotary A=head -o out.t4d", "--rotary: A is given twice");
  misused(all + "--offset G60=1,2,3 -o out.t4d", "--offset: 'G60=1,2,3' is not an offset");
  misused(
      "mill fx/cube.obj --tool flat:d=6,l=30 --motion fx/rest.json --tcp --voxel-size 4 -o out.t4d",
      "are for --gcode");
}

TEST_F(Program, MillTakesABlockAndWritesThePart) {
  // A slot of 20 x 6 x 2, from outside of the block to outside of it.
  write("slot.nc", "G1 X-15 Y0 Z-2\nX15 F600\n");
  const std::string mill =
      "mill --stock box:20,20,10 --tool flat:d=6,l=30 --gcode slot.nc --voxel-size 0.5 --frames 3 ";
  const Finished part = run(mill + "--feed 1200 --json -o part.stl");
  EXPECT_NE(part.err.find("the tool begins at (0, 0, 0) mm, the middle of the stock's top"),
            std::string::npos)
      << part.err;
  EXPECT_NE(part.err.find("the way there from where the tool begins is drawn as a rapid move"),
            std::string::npos);
  const json done = part.value();
  EXPECT_NEAR(done["stock_volume"].get<double>(), 4000, 40);
  EXPECT_NEAR(done["removed_volume"].get<double>(), 240, 24);
  EXPECT_NEAR(done["path"]["cutting"][0]["time"].get<double>(), 30.0 / 10, 1e-9);
  EXPECT_EQ(done["path"]["min"], json::array({-15.0, 0.0, -2.0}));
  EXPECT_EQ(done["path"]["tool_changes"], 0);
  const json mended = run("mend part.stl -o mended.ply --json").value();
  EXPECT_NEAR(mended["volume_after"].get<double>(), done["remaining_volume"].get<double>(), 1e-3);
  // Where it is told, it cuts from there.
  const json told = run(mill + "--feed 1200 --start -15,0,-2 --json -o told.t4d").value();
  EXPECT_EQ(told["path"]["rapid_time"], 0);
  // The wall is thinner than a voxel.
  const Finished thin =
      run("mill --stock box:20,0.3,10 --tool flat:d=6,l=30 --gcode slot.nc --voxel-size 0.4 "
          "--frames 3 --feed 60 -o thin.t4d");
  EXPECT_EQ(thin.exitCode, 3);
  EXPECT_NE(thin.err.find("walls thinner than a voxel (0.4)"), std::string::npos) << thin.err;
  misused(mill + "fx/cube.obj -o x.t4d", "is given by a file, or by --stock");
  misused(mill + "--start 1,2 -o x.t4d", "--start: found '1,2', expected a point");
  misused(mill + "--dialect foo -o x.t4d", "foo not in");
  misused("mill --stock box:1,2 --tool flat:d=6,l=30 --gcode slot.nc --voxel-size 1 -o x.t4d",
          "is no stock; expected box:LENGTH,WIDTH,HEIGHT");
}

}  // namespace
}  // namespace t4d::tools
