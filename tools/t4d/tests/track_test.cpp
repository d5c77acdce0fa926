#include <gmock/gmock.h>

#include "tools/t4d/tests/program.h"

/// `t4d track`.
namespace t4d::tools {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

TEST_F(Program, TracksWriteTablesGraphsAndAPicture) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  const json report = run("track cube.t4d --frames 3 --json").value();
  ASSERT_EQ(report["tracks"].size(), 1U);
  const json& track = report["tracks"][0];
  EXPECT_EQ(track["id"], 1);
  EXPECT_EQ(track["begins"], "mesh");
  EXPECT_EQ(track["ends"], "mesh");
  ASSERT_EQ(track["samples"].size(), 3U);
  EXPECT_TRUE(track["samples"][0]["speed"].is_null());
  EXPECT_NEAR(track["samples"][1]["speed"], 1, 1e-12);
  EXPECT_NEAR(track["samples"][1]["volume"], 8000, 1e-6);
  EXPECT_TRUE(report["events"].empty());
  // At all layers.
  EXPECT_EQ(run("track cube.t4d --json").value()["tracks"][0]["samples"].size(), 65U);
  EXPECT_THAT(run("track cube.t4d").out, HasSubstr("mesh"));

  ASSERT_EQ(run("track cube.t4d -o t.csv -o t.json -o t.graphml -o t.dot -o t.svg --events e.csv "
                "--samples s.csv --surfaces")
                .exitCode,
            0);
  EXPECT_THAT(contents(folder_ / "t.csv"), HasSubstr("\n1,paper-cube,solid,0,64,mesh,mesh,,,"));
  EXPECT_THAT(contents(folder_ / "t.graphml"), HasSubstr("<node id=\"1\">"));
  EXPECT_THAT(contents(folder_ / "t.dot"), StartsWith("digraph"));
  EXPECT_THAT(contents(folder_ / "t.svg"), HasSubstr("<polygon"));
  EXPECT_THAT(contents(folder_ / "e.csv"), StartsWith("time,event,body,x,y,z,before,after,"));
  EXPECT_THAT(contents(folder_ / "s.csv"), HasSubstr("\n1,paper-cube,64,"));
  EXPECT_EQ(json::parse(contents(folder_ / "t.json"))["tracks"].size(), 1U);

  refuses("track cube.t4d --times 0:500:2", "time 500 is outside the mesh");
  misused("track cube.t4d -o out.ply", "does not end with");
  misused("track cube.t4d --min-volume -1", "");
}

}  // namespace
}  // namespace t4d::tools
