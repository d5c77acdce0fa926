#include <fmt/format.h>
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
  // By default samples are at all layers.
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

  ASSERT_EQ(run("track cube.t4d --contacts c.csv").exitCode, 0);
  EXPECT_EQ(contents(folder_ / "c.csv"),
            "contact,body,other,begin,end,largest_area,time,area,length_unit,time_unit\n");

  refuses("track cube.t4d --times 0:500:2", "time 500 is outside the mesh");
  misused("track cube.t4d -o out.ply", "does not end with");
  misused("track cube.t4d --min-volume -1", "");
}

TEST_F(Program, TracksOfPartsAreJoined) {
  ASSERT_EQ(run("mill fx/cube.obj --tool flat:d=4,l=30 --gcode fx/parting.nc --voxel-size 1 "
                "--frames 12 --up z -o parted.t4d")
                .exitCode,
            0);
  for (const std::string options : {"", " --surfaces", " --frames 5 --min-volume 4000"}) {
    const json whole = run("track parted.t4d --json" + options).value();
    const int most = run("track parted.t4d --most-parts").value()["parts"];
    EXPECT_EQ(most, 13);
    for (const int count : {2, most}) {
      std::string files;
      for (int k = 1; k <= count; ++k) {
        const auto part =
            run(fmt::format("track parted.t4d --json --part {}/{}{}", k, count, options));
        ASSERT_EQ(part.exitCode, 0) << part.err;
        std::ofstream(folder_ / fmt::format("p{}.json", k)) << part.out;
        files += fmt::format(" p{}.json", k);
      }
      EXPECT_EQ(run("join" + files).value(), whole) << count << options;
    }
  }
  misused("track parted.t4d --part 1/2", "--part needs --json");
  misused("track parted.t4d --part 1/2 --json -o t.csv", "--part needs --json");
  misused("track parted.t4d --part 1/20 --json", "too few for 20 parts");
}

TEST_F(Program, FilterKeepsATrack) {
  ASSERT_EQ(run("mill fx/cube.obj --tool flat:d=4,l=30 --gcode fx/parting.nc --voxel-size 1 "
                "--frames 12 --up z -o parted.t4d")
                .exitCode,
            0);
  const json whole = run("track parted.t4d --json").value();
  ASSERT_EQ(whole["tracks"].size(), 3U);
  double sum = 0;
  for (const json& track : whole["tracks"]) {
    const std::string id = track["id"].dump();
    const json filtered = run("filter parted.t4d --track " + id + " -o t.t4d --json").value();
    EXPECT_EQ(filtered["time_begin"], track["begin"]);
    EXPECT_EQ(filtered["time_end"], track["end"]);
    EXPECT_EQ(filtered["caps"].size(), 2U);
    const json valid = run("validate t.t4d --deep --json").value();
    EXPECT_TRUE(valid["valid"] && valid["closed"] && valid["vertex_links_ok"]);
    sum += valid["hypervolume"].get<double>();
    const json alone = run("track t.t4d --json").value();
    EXPECT_EQ(alone["tracks"].size(), 1U);
    EXPECT_TRUE(alone["events"].empty());
  }
  const double all = run("validate parted.t4d --json").value()["hypervolume"];
  EXPECT_NEAR(sum, all, 1e-10 * all);
  refuses("filter parted.t4d --track 4 -o out.t4d", "parted.t4d: has no track 4; it has 3");
  misused("filter parted.t4d --track 1 --from 2 -o out.t4d", "--track excludes --from and --to");
  misused("filter parted.t4d --track 0 -o out.t4d", "");
}

}  // namespace
}  // namespace t4d::tools
