#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tools/t4d/tests/box.h"
#include "tools/t4d/tests/program.h"

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
  refuses("mend fx/open-pebble.stl -o no.xyz", "does not end with", 2);
  refuses("sweep fx/cube.obj --max-hole 1 -m fx/rest.json -o out.t4d", "--mend", 2);
  EXPECT_FALSE(fs::exists(folder_ / "no.ply"));
}

TEST_F(Program, SaysWhatMendingChangedOfEachBody) {
  // A box, and a cube with a fin that reaches 3 out of it.
  const std::string small = boxText({0, 0, 0}, {1, 1, 1});
  const std::string fin = "v 0.5 0.5 4\nf -2 -3 -1\n";
  write("fin.obj", small + fin);
  write("two.obj", "o box\n" + boxText({2, 0, 0}, {3, 1, 1}) + "o finned\n" + small + fin);
  const std::string lost = "lost: mending dropped what 1 triangle has outside of the solid";
  const Finished done = run("mend fin.obj -o out.ply --json");
  EXPECT_EQ(done.exitCode, 3);
  EXPECT_THAT(done.err, testing::HasSubstr(lost));
  const json report = json::parse(done.out);
  EXPECT_EQ(report["lost_triangles"], 1);
  EXPECT_NEAR(report["lost_distance"].get<double>(), 3, 1e-12);
  EXPECT_EQ(report["bodies"][0]["bounds_before"]["max"][2], 4);
  EXPECT_EQ(report["bodies"][0]["bounds_after"]["max"][2], 1);
  EXPECT_THAT(run("mend fin.obj -o out.ply").out,
              testing::HasSubstr("extent 1 x 1 x 1, 1 x 1 x 4 before"));

  const Finished swept = run("sweep two.obj --bodies object --mend -m fx/rest.json -o two.t4d");
  EXPECT_EQ(swept.exitCode, 3);
  EXPECT_THAT(swept.err, testing::HasSubstr("note: body 'finned': mended: volume 1, open before"));
  EXPECT_THAT(swept.err, testing::HasSubstr("lost: body 'finned': mending dropped"));
  EXPECT_THAT(swept.err, testing::Not(testing::HasSubstr("body 'box'")));
  const Finished clear = run("collide two.t4d --json");
  EXPECT_EQ(clear.exitCode, 0) << clear.err;
  EXPECT_THAT(clear.err,
              testing::HasSubstr("note: the answer is about 1 body as the file has it: 'finned' of "
                                 "two.t4d was mended (volume 1, open before; surface moved by up "
                                 "to 3"));
  const json mended = json::parse(clear.out)["mended"];
  ASSERT_EQ(mended.size(), 1U);
  EXPECT_EQ(mended[0]["body"], "finned");
  EXPECT_EQ(mended[0]["lost_triangles"], 1);

  // A mechanism; and one body without a name.
  write(
      "m.json",
      R"({"bodies": [{"name": "a", "solid": "fin.obj", "joint": {"type": "prismatic", "axis": [1, 0, 0]},
                        "motion": {"times": [0, 1], "values": [0, 1]}},
                       {"name": "b", "solid": "fin.obj", "position": [0, 3, 0]}]})");
  const Finished robot = run("sweep m.json --mend --hull never -o m.t4d --json");
  EXPECT_EQ(robot.exitCode, 3) << robot.err;
  EXPECT_THAT(robot.err, testing::HasSubstr("lost: body 'b': mending dropped"));
  EXPECT_EQ(run("sweep fin.obj --mend -m fx/rest.json -o one.t4d").exitCode, 3);
  EXPECT_THAT(run("collide one.t4d two.t4d").err, testing::HasSubstr("'fin' of one.t4d was"));
  EXPECT_EQ(run("voxelize fin.obj --mend -m fx/rest.json --voxel-size 0.25 -o v").exitCode, 3);
}

TEST_F(Program, ListsTheFaultsOfAllBodies) {
  const std::string box = boxText({0, 0, 0}, {1, 1, 1});
  const std::string open = box.substr(0, box.rfind("f "));
  const std::string sheet = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nf -3 -1 -2\n";
  write("open.obj", "o a\n" + open + "o b\n" + box + "o c\n" + open);
  const std::string sweep = "sweep open.obj --bodies object -m fx/rest.json -o out.t4d";
  refuses(sweep, "body 'a': the mesh is open");
  refuses(sweep, "body 'c': the mesh is open");
  write("sheets.obj", "o a\n" + sheet + "o b\n" + box + "o c\n" + sheet);
  for (const std::string verb :
       {"mend sheets.obj -o out.glb", "sweep sheets.obj --mend -m fx/rest.json -o out.t4d"}) {
    refuses(verb + " --bodies object", "body 'a': the surface encloses nothing");
    refuses(verb + " --bodies object", "body 'c': the surface encloses nothing");
  }
  write("a.obj", sheet);
  write(
      "m.json",
      R"({"bodies": [{"name": "a", "solid": "a.obj", "joint": {"type": "prismatic", "axis": [1, 0, 0]},
                        "motion": {"times": [0, 1], "values": [0, 1]}},
                       {"name": "b", "solid": "a.obj", "position": [0, 3, 0]}]})");
  EXPECT_THAT(run("sweep m.json --mend -o out.t4d").err,
              testing::ContainsRegex("encloses nothing.*\n.*encloses nothing"));
}

TEST_F(Program, AdvisesNoMendingOfWhatWasMended) {
  // The union of two cubes a billionth apart, which TetGen cannot fill.
  write("steps.obj", boxText({0, 0, 0}, {1, 1, 1}) +
                         boxText({1e-9, 1e-9, 1e-9}, {1 + 1e-9, 1 + 1e-9, 1 + 1e-9}));
  refuses("sweep steps.obj -m fx/rest.json -o out.t4d", "try: t4d mend steps.obj");
  const Finished done = run("sweep steps.obj --mend -m fx/rest.json -o out.t4d");
  EXPECT_EQ(done.exitCode, 1) << done.err;
  EXPECT_THAT(done.err, testing::HasSubstr("t4d: try: --caps cone\n"));
  EXPECT_EQ(run("sweep steps.obj --mend --caps cone -m fx/rest.json -o steps.t4d").exitCode, 0);
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

/// What mending carries is the same whether it is done before the sweep or by it.
TEST_F(Program, MendingKeepsAttributes) {
  // A box without its last side, whose first sides are of wood, each with the same square of a
  // texture.
  const std::string vertices =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\nv 1 0 1\nv 0 1 1\nv 1 1 1\n";
  write("open.obj", vertices +
                        "vt 0 0\nvt 0.25 0\nvt 0.25 0.5\nvt 0 0.5\nusemtl wood\n"
                        "f 1/1 3/2 4/3 2/4\nf 5/1 6/2 8/3 7/4\nusemtl steel\n"
                        "f 1/1 2/2 6/3 5/4\nf 4/1 3/2 7/3 8/4\nf 3/1 1/2 5/3 7/4\n");
  std::string colored =
      "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\n"
      "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
      "element face 5\nproperty list uchar int vertex_indices\nend_header\n";
  for (int i = 0; i < 8; ++i) {
    colored += fmt::format("{} {} {} {} {} 7\n", i & 1, i >> 1 & 1, i >> 2, 30 * i, 255 - i);
  }
  write("open.ply", colored + "4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 3 2 6 7\n4 2 0 4 6\n");
  for (const auto& [extension, marks] :
       {std::pair{std::string("obj"),
                  std::vector{"usemtl wood\n", "usemtl steel\n", "\nvt 0.25 0.5\n"}},
        {std::string("ply"), std::vector{"property uchar blue\n"}}}) {
    const std::string slice = " --time 0 --light --attributes -o ";
    const Finished mended = run("mend open." + extension + " -o mended." + extension);
    ASSERT_EQ(mended.exitCode, 0) << mended.err;
    ASSERT_EQ(run("sweep mended." + extension + " -m fx/rest.json --body b -o after.t4d").exitCode,
              0);
    ASSERT_EQ(
        run("sweep open." + extension + " --mend -m fx/rest.json --body b -o by.t4d").exitCode, 0);
    for (const char* by : {"after", "by"}) {
      run(fmt::format("slice {}.t4d{}{}.{}", by, slice, by, extension));
    }
    const std::string after = contents(folder_ / ("after." + extension));
    EXPECT_EQ(after, contents(folder_ / ("by." + extension)));
    for (const char* mark : marks) EXPECT_THAT(after, testing::HasSubstr(mark));
  }
  EXPECT_EQ(run("info by.t4d --json").value()["details"].contains("materials"), false);
  // Attributes that a format has no room for are lost.
  const Finished lost = run("mend open.obj -o mended.stl");
  EXPECT_EQ(lost.exitCode, 3);
  EXPECT_THAT(lost.err,
              testing::HasSubstr("lost: triangle attribute 'uv:corners': STL has no room"));
  const Finished numbers = run("mend open.obj -o mended.ply");
  EXPECT_EQ(numbers.exitCode, 3);
  EXPECT_THAT(numbers.err, testing::HasSubstr("lost: the names of 2 materials: .ply has none"));
}

}  // namespace
}  // namespace t4d::tools
