#include <cmath>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tools/t4d/tests/box.h"
#include "tools/t4d/tests/program.h"

/// `t4d collide` and `resolve`.
namespace t4d::tools {
namespace {

constexpr const char* kTurn =
    R"({"segments": [{"duration": 1, "axis_direction": [0, 0, 1], "angle_degrees": 170}]})";
constexpr const char* kStay = R"({"segments": [{"duration": 1}]})";

TEST_F(Program, CollideRefusesOtherUnitsUnlessTheyAreIgnored) {
  for (const char* unit : {"mm", "m"}) {
    write(std::string(unit) + ".json",
          std::string(R"({"length_unit": ")") + unit + R"(", "segments": [{"duration": 1}]})");
    ASSERT_EQ(
        run(std::string("sweep fx/cube.obj -m ") + unit + ".json -o " + unit + ".t4d").exitCode, 0);
  }
  refuses("collide mm.t4d m.t4d", "the unit of length is 'm', but that of mm.t4d is 'mm'");
  const Finished done = run("collide mm.t4d m.t4d --ignore-units --json");
  ASSERT_EQ(done.exitCode, 0) << done.err;
  EXPECT_EQ(done.value()["pairs"][0]["verdict"], "hit");
}

TEST_F(Program, CollideNeverContradictsItsClearance) {
  write("turn.json", kTurn);
  write("stay.json", kStay);
  write("bar.obj", boxText({-5, -1, -1}, {5, 1, 1}));
  // The corners of the bar come as near as 0.2 to the wall, whatever the steps.
  const double gap = 0.2;
  const double near = std::sqrt(26) + gap;
  write("wall.obj", boxText({-20, near, -2}, {20, near + 2, 2}));
  ASSERT_EQ(run("sweep wall.obj -m stay.json -o wall.t4d").exitCode, 0);
  for (const std::string steps : {"12", "60", "400"}) {
    ASSERT_EQ(run("sweep bar.obj -m turn.json --steps " + steps + " -o bar.t4d").exitCode, 0);
    for (const double clearance : {0.01, 0.15, 0.19, 0.1999, 0.2001, 0.21, 0.3, 1.0}) {
      const std::string command =
          fmt::format("collide bar.t4d wall.t4d --fail-on-contact --clearance {} ", clearance);
      SCOPED_TRACE(steps + ": " + command);
      const Finished done = run(command);
      const json pair = run(command + "--json").value()["pairs"][0];
      const bool keeps = pair["keeps_clearance"];
      EXPECT_FALSE(keeps && clearance > gap);
      EXPECT_FALSE(pair["breaks_clearance"] && clearance < gap);
      EXPECT_FALSE(keeps && pair["breaks_clearance"]);
      EXPECT_EQ(done.exitCode, keeps ? 0 : 1);
      // The printed text supports the answer.
      const std::string clear = "clear by at least ";
      const std::size_t at = done.out.find(clear);
      const double printed =
          at == std::string::npos ? 0 : std::stod(done.out.substr(at + clear.size()));
      EXPECT_EQ(printed >= clearance, keeps) << done.out;
      EXPECT_EQ(done.out.find("is kept\n") != std::string::npos, keeps) << done.out;
    }
  }
}

TEST_F(Program, ResolveSaysWhichClearanceDecides) {
  write("turn.json", kTurn);
  write("stay.json", kStay);
  write("bar.obj", boxText({-5, -1, -1}, {5, 1, 1}));
  ASSERT_EQ(run("sweep bar.obj -m turn.json --steps 12 -o bar.t4d").exitCode, 0);
  write("wall.obj", boxText({-20, 5.12, -2}, {20, 7, 2}));
  ASSERT_EQ(run("sweep wall.obj -m stay.json -o wall.t4d").exitCode, 0);
  const Finished open = run("resolve bar.t4d wall.t4d -o apart.t4d --json");
  ASSERT_EQ(open.exitCode, 0) << open.err;
  const double enough = open.value()["deciding_clearance"];
  EXPECT_GT(enough, open.value()["chord_bound"].get<double>());
  EXPECT_THAT(open.err, testing::HasSubstr(fmt::format("--clearance {} ", enough)));
  EXPECT_EQ(run("collide bar.t4d apart.t4d --fail-on-contact").exitCode, 1);
  const Finished sure =
      run(fmt::format("resolve bar.t4d wall.t4d -o apart.t4d --json --clearance {}", enough));
  ASSERT_EQ(sure.exitCode, 0) << sure.err;
  EXPECT_TRUE(sure.value()["deciding_clearance"].is_null());
  EXPECT_EQ(sure.err.find("note"), std::string::npos) << sure.err;
  EXPECT_EQ(run("collide bar.t4d apart.t4d --fail-on-contact").exitCode, 0);
}

TEST_F(Program, UnitsCanBeConvertedForCollide) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  ASSERT_EQ(run("transform cube.t4d --length-unit in --time-unit s --up z -o inch.t4d").exitCode,
            0);
  ASSERT_EQ(run("transform cube.t4d --length-unit mm --time-unit s --up z -o mm.t4d").exitCode, 0);
  refuses("collide inch.t4d mm.t4d", "t4d transform --scale FACTOR --length-unit NAME");
  ASSERT_EQ(run("transform inch.t4d --scale 25.4 --length-unit mm -o same.t4d").exitCode, 0);
  EXPECT_EQ(run("info same.t4d --json").value()["up"], "z");
  const Finished done = run("collide same.t4d mm.t4d --fail-on-contact -o two.glb --html two.html");
  EXPECT_EQ(done.exitCode, 1) << done.err;
  EXPECT_THAT(done.out, testing::HasSubstr("two.glb: "));
  EXPECT_THAT(done.out, testing::HasSubstr("two.html: "));
}

TEST_F(Program, CollideDrawsTheClearanceOverTime) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  ASSERT_EQ(run("transform cube.t4d --move 25 0 0 -o beside.t4d").exitCode, 0);
  const Finished done = run("collide cube.t4d beside.t4d --html clear.html");
  EXPECT_EQ(done.exitCode, 0) << done.err;
  const std::string page = contents(folder_ / "clear.html");
  EXPECT_NE(page.find("clear by at least 5"), std::string::npos);
  EXPECT_NE(page.find("clearance: 5 at 0"), std::string::npos);
}

TEST_F(Program, CollideLeavesOutPairsAndWritesTables) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  ASSERT_EQ(run("transform cube.t4d --move 25 0 0 -o beside.t4d").exitCode, 0);
  const std::string name = run("info cube.t4d --json").value()["bodies"][0]["name"];
  const Finished done =
      run("collide cube.t4d beside.t4d --frames 3 -o c.csv -o c.json -o c.svg -o c.png -o c.glb");
  ASSERT_EQ(done.exitCode, 0) << done.err;
  EXPECT_THAT(contents(folder_ / "c.csv"),
              testing::HasSubstr(fmt::format("\n32,{0},{0},5,4.99", name)));
  EXPECT_EQ(json::parse(contents(folder_ / "c.json"))["pairs"][0]["samples"].size(), 3);
  EXPECT_THAT(contents(folder_ / "c.svg"), testing::HasSubstr("Clearance"));
  EXPECT_TRUE(contents(folder_ / "c.png").starts_with("\x89PNG"));
  // Bodies that never exist together have a table and a plot without rows.
  ASSERT_EQ(run("transform cube.t4d --time-shift 100 -o late.t4d").exitCode, 0);
  EXPECT_EQ(run("collide cube.t4d late.t4d -o n.csv -o n.svg --html n.html").exitCode, 0);
  EXPECT_EQ(contents(folder_ / "n.csv"), "time,a,b,distance,lower_bound,overlap_depth\n");
  EXPECT_THAT(contents(folder_ / "n.svg"), testing::EndsWith("</svg>\n"));
  const auto srdf = [&](const std::string& text) {
    write("arm.srdf", text);
    return run("collide cube.t4d beside.t4d --ignore arm.srdf");
  };
  const std::string pair =
      fmt::format("<disable_collisions link1=\"{0}\" link2=\"{0}\" reason=\"Never\"/>", name);
  EXPECT_THAT(srdf("<robot name=\"arm\">" + pair + "</robot>").err,
              testing::HasSubstr("all pairs of bodies are left out"));
  EXPECT_EQ(srdf("<robot name=\"arm\"/>").exitCode, 0);
  EXPECT_THAT(srdf("<robot>\n<disable_collisions link1=\"a\"/>\n</robot>").err,
              testing::HasSubstr("arm.srdf:2: <disable_collisions> has no link1 or no link2"));
  EXPECT_THAT(srdf("<sdf/>").err, testing::HasSubstr("arm.srdf:1: begins with <sdf>"));
  EXPECT_THAT(srdf("<robot>").err, testing::HasSubstr("arm.srdf:1: is not XML"));
  EXPECT_THAT(run("collide cube.t4d beside.t4d --ignore x:y").err,
              testing::HasSubstr("there are " + name));
}

TEST_F(Program, BodiesThatNeverExistTogetherAreClearByNothing) {
  ASSERT_EQ(run("sweep fx/cube.obj -m fx/rest.json -o cube.t4d").exitCode, 0);
  ASSERT_EQ(run("transform cube.t4d --time-shift 1000000000 -o late.t4d").exitCode, 0);
  const json pair = run("collide cube.t4d late.t4d --json").value()["pairs"][0];
  EXPECT_EQ(pair["verdict"], "clear");
  EXPECT_TRUE(pair["clear_by"].is_null());
  // Large times keep their digits.
  ASSERT_EQ(run("transform late.t4d --time-shift 1 -o later.t4d").exitCode, 0);
  EXPECT_THAT(run("collide late.t4d later.t4d").out, testing::Not(testing::HasSubstr("e+09")));
}

TEST_F(Program, CollideFailsOnWhatMayBeContact) {
  // In a single step of a quarter turn the mesh does not reach what the cube does.
  write("turn.json", R"({"segments": [{"duration": 1, "axis_direction": [0, 0, 1],)"
                     R"( "angle_degrees": 90}]})");
  ASSERT_EQ(run("sweep fx/cube.obj -m turn.json --steps 1 -o turn.t4d").exitCode, 0);
  ASSERT_EQ(run("sweep fx/cube.obj -m fx/rest.json -o rest.t4d").exitCode, 0);
  ASSERT_EQ(run("transform rest.t4d --move 21 0 0 -o beside.t4d").exitCode, 0);
  const Finished done = run("collide turn.t4d beside.t4d --json --fail-on-contact");
  EXPECT_EQ(done.exitCode, 1);
  EXPECT_EQ(done.value()["pairs"][0]["verdict"], "within-tolerance");
  EXPECT_EQ(done.value()["pairs"][0]["contact"], false);
}

}  // namespace
}  // namespace t4d::tools
