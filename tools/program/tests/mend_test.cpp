#include <filesystem>
#include <string>

#include "tools/program/tests/program.h"

/// `t4d mend`, and `sweep --mend`.
namespace t4d::tools {
namespace {

TEST_F(Program, MendsWhatSweepRefuses) {
  refuses("sweep fx/crossing-balls.stl -m fx/rest.json -o out.t4d", "try: t4d mend");
  refuses("sweep fx/open-pebble.stl -m fx/rest.json -o out.t4d", "try: t4d mend");
  for (const std::string name : {"crossing-balls", "open-pebble", "touching-cubes"}) {
    const std::string sweep = " -m fx/rest.json -o swept.t4d";
    ASSERT_EQ(run("mend fx/" + name + ".stl -o mended.ply").exitCode, 0) << name;
    EXPECT_EQ(run("sweep mended.ply" + sweep).exitCode, 0) << name;
    EXPECT_EQ(run("sweep fx/" + name + ".stl --mend" + sweep).exitCode, 0) << name;
    // What is mended needs no mending, in any format that keeps all digits.
    for (const std::string format : {"ply", "obj", "off"}) {
      ASSERT_EQ(run("mend mended.ply -o again." + format).exitCode, 0);
      EXPECT_EQ(run("mend again." + format + " -o last.ply --json").value()["changes"].size(), 0U);
    }
  }
  const json cubes = run("mend fx/touching-cubes.stl -o mended.stl --json").value();
  EXPECT_NEAR(cubes["volume_after"].get<double>(), 3000, 0.2);
  refuses("mend fx/open-pebble.stl --max-hole 1 -o no.ply", "try: a larger --max-hole");
  refuses("mend fx/open-pebble.stl --max-move 0.01 -o no.ply", "try: a larger --max-move");
  refuses("mend fx/open-pebble.stl -o no.xyz", "unsupported output extension", 2);
  refuses("sweep fx/cube.obj --max-hole 1 -m fx/rest.json -o out.t4d", "--mend", 2);
  EXPECT_FALSE(fs::exists(folder_ / "no.ply"));
}

TEST_F(Program, MendsDeformations) {
  // A tetrahedron without a side, which grows.
  const std::string faces = "f 1 3 2\nf 1 2 4\nf 1 4 3\n";
  write("open0.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n" + faces);
  write("open1.obj", "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 0 0 2\n" + faces);
  refuses("sweep open0.obj open1.obj --frame-time 1 -o out.t4d", "is open");
  const json done =
      run("sweep open0.obj open1.obj --frame-time 1 --mend -o grown.t4d --json").value();
  EXPECT_EQ(done["mend"]["changes"][0]["kind"], "hole");
  // The volume is (1 + t)^3 / 6.
  const json judged = run("validate --deep --json grown.t4d").value();
  EXPECT_NEAR(judged["hypervolume"].get<double>(), 15.0 / 24, 1e-12);
  refuses("sweep open0.obj open1.obj --frame-time 1 --mend --max-hole 1 -o out.t4d",
          "wider than 1");
  misused("sweep open0.obj open1.obj --frame-time 1 --mend --remesh 1 -o out.t4d",
          "moves no vertex");
}

}  // namespace
}  // namespace t4d::tools
