#include <cstdint>
#include <string>

#include <fmt/format.h>

#include "tools/t4d/tests/program.h"

/// `t4d simplify` and `quality`.
namespace t4d::tools {
namespace {

TEST_F(Program, QualityRefusesWhatWouldSayNothing) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  misused("quality cube.t4d --attributes volume", "name it with -o");
  misused("quality cube.t4d --time-scale 1e300", "volumes would overflow");
  misused("quality cube.t4d --time-scale 1e-300", "volumes would vanish");
}

TEST_F(Program, SimplifyKeepsItsPromise) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  const json done = run("simplify cube.t4d --max-error 0.1 --json -o small.t4d").value();
  EXPECT_EQ(done["cells_before"], 21552);
  EXPECT_LT(done["cells"], 2155);
  EXPECT_EQ(done["max_error"], 0.1);
  EXPECT_LE(done["measured_error"], 0.1);
  EXPECT_NEAR(done["hypervolume"].get<double>(), 512000, 1e-5);
  EXPECT_EQ(run("validate small.t4d --deep").exitCode, 0);
  const Finished swept = run("simplify cube.t4d --ratio 0.5 --html page.html --json -o half.t4d");
  EXPECT_EQ(swept.exitCode, 0);
  EXPECT_NE(swept.err.find("is small as it is"), std::string::npos) << swept.err;
  EXPECT_TRUE(swept.value()["max_error"].is_null());
  for (const char* said : {"<h2>The solids</h2>", "b: half.t4d, by its distance from a"}) {
    EXPECT_NE(contents(folder_ / "page.html").find(said), std::string::npos) << said;
  }
  ASSERT_EQ(run("transform cube.t4d --time-scale 1e9 -o slow.t4d").exitCode, 0);
  const Finished needles = run("simplify slow.t4d --ratio 0.5 --time-scale 1 -o half.t4d");
  EXPECT_NE(needles.err.find("is a better scale"), std::string::npos) << needles.err;
  misused("simplify cube.t4d --ratio 0.5 --html half.t4d -o half.t4d", "does not end with .html");
  misused("simplify cube.t4d --ratio 2 -o out.t4d", "not above 0 and at most 1");
  misused("simplify cube.t4d --max-error 1e-12 -o out.t4d", "allow at least");
  misused("simplify cube.t4d --ratio 0.5 --preserve nothing -o out.t4d", "no attribute 'nothing'");
  misused("simplify cube.t4d --ratio 0.5 -o cube.t4d", "input");
}

TEST_F(Program, PartsOfASimplifiedMeshAreJoined) {
  ASSERT_EQ(run("weave fx/labels.nrrd --label 2 -o woven.t4d").exitCode, 0);
  std::uint64_t cells = 0;
  std::string parts;
  for (const char* number : {"1", "2", "3"}) {
    const std::string part = fmt::format("part-{}.t4d", number);
    const json done = run(fmt::format("simplify woven.t4d --ratio 0.5 --time-scale 1 --window 1 "
                                      "--part {}/3 --json -o {}",
                                      number, part))
                          .value();
    cells += done["cells"].get<std::uint64_t>();
    parts += part + " ";
  }
  ASSERT_EQ(run("join " + parts + "-o joined.t4d").exitCode, 0);
  EXPECT_EQ(run("validate joined.t4d --deep").exitCode, 0);
  EXPECT_EQ(run("info joined.t4d --json").value()["tetrahedra"], cells);
  EXPECT_LT(cells, run("info woven.t4d --json").value()["tetrahedra"]);
  misused("simplify woven.t4d --ratio 0.5 --part 4/3 -o out.t4d", "K from 1 to N");
  misused("simplify woven.t4d --ratio 0.5 --window 1 --part 1/99 -o out.t4d", "fewer parts");
}

}  // namespace
}  // namespace t4d::tools
