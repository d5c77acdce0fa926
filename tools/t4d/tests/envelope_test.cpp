#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tools/t4d/tests/box.h"
#include "tools/t4d/tests/program.h"

/// `t4d envelope`, and `join` of the parts of its fields.
namespace t4d::tools {
namespace {

TEST_F(Program, EnvelopeOfThePapersCubeIsTheSameInAllFormats) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  for (const std::string format : {"stl", "glb", "ply", "obj"}) {
    const std::string file = "envelope." + format;
    const json made = run("envelope cube.t4d --voxel-size 2.1 --json -o " + file).value();
    EXPECT_NEAR(made["volume"].get<double>(), 33600, 0.01);
    EXPECT_NEAR(made["visits_volume"].get<double>(), 33600, 1e-8);
    EXPECT_NEAR(made["hypervolume"].get<double>(), 512000, 1e-7);
    EXPECT_NEAR(made["hypervolume_by_flux"].get<double>(), 512000, 1e-7);
    EXPECT_EQ(made["voxel_size"], 2.1);
    EXPECT_EQ(made["self_intersections"], 0);
    // When read again, the mesh is neither open nor crossing, nor flat anywhere.
    EXPECT_EQ(run("mend " + file + " -o again.ply --json").value()["changes"].size(), 0U);
  }
  const json exact = run("envelope cube.t4d --exact --json").value();
  EXPECT_NEAR(exact["volume"].get<double>(), 33600, 1e-7);
  EXPECT_TRUE(exact["voxel_size"].is_null());
  const json part = run("envelope cube.t4d --from 1.5 --to 3 --voxel-size 2 --json").value();
  EXPECT_NEAR(part["volume"].get<double>(), 400 * 21.5, 1e-3);
  EXPECT_NEAR(part["hypervolume"].get<double>(), 1.5 * 8000, 1e-7);
  const json late = run("envelope cube.t4d --from 62.5 --to 100 --voxel-size 2 --json").value();
  EXPECT_EQ(late["time_begin"], 62.5);
  EXPECT_EQ(late["time_end"], 64.0);
}

TEST_F(Program, EnvelopeWritesFieldsThatWeaveReads) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  fs::create_directory(folder_ / "fields");
  for (const std::string frame : {"0", "1"}) {
    ASSERT_EQ(run("envelope cube.t4d --voxel-size 2 --visits visits.vdb --dwell fields/frame_" +
                  frame + ".vdb --first first.vdb --last last.vdb")
                  .exitCode,
              0);
  }
  // Where the dwell is more than 10 of at most 20, z is between 0 and 64.
  ASSERT_EQ(run("weave fields --iso 10 --frame-time 1 -o dwell.t4d").exitCode, 0);
  const json slice = run("slice dwell.t4d --time 0.5 --json").value();
  EXPECT_NEAR(slice["volume"].get<double>(), 20 * 20 * 64, 0.1 * 20 * 20 * 64);
}

TEST_F(Program, PartsOfTheFieldsOfAnEnvelopeJoinToTheWhole) {
  ASSERT_EQ(run("sweep fx/cube.obj -m fx/paper-screw.json -o turning.t4d").exitCode, 0);
  const std::vector<std::string> names = {"visits", "dwell", "first", "last"};
  const auto options = [&](const std::string& suffix) {
    std::string text;
    for (const std::string& name : names) text += fmt::format(" --{0} {0}{1}.vdb", name, suffix);
    return text;
  };
  // The size of voxels is given, or follows from the memory.
  for (const std::string size : {"--voxel-size 1.5", "--max-memory 0.05"}) {
    const std::string envelope = "envelope turning.t4d --json " + size;
    const json whole = run(envelope + options("")).value();
    const int most = run(envelope + " --most-parts").value()["parts"];
    for (const int count : {1, 3, most}) {
      std::map<std::string, std::string> parts;
      for (int k = count; k >= 1; --k) {
        const std::string suffix = fmt::format("-{}", k);
        const json part =
            run(fmt::format("{}{} --part {}/{}", envelope, options(suffix), k, count)).value();
        EXPECT_EQ(part["part"]["number"], k);
        EXPECT_EQ(part["fields"].size(), 4U);
        EXPECT_TRUE(part["volume"].is_null());
        for (const char* same : {"voxel_size", "hypervolume", "silhouette_triangles"}) {
          EXPECT_EQ(part[same], whole[same]) << same;
        }
        for (const std::string& name : names) parts[name] += " " + name + suffix + ".vdb";
      }
      for (const std::string& name : names) {
        const json joined = run("join --json -o joined.vdb" + parts[name]).value();
        EXPECT_EQ(joined["parts"], count);
        EXPECT_EQ(joined["field"], name);
        EXPECT_EQ(joined["bytes"], fs::file_size(folder_ / "joined.vdb"));
        EXPECT_EQ(contents(folder_ / "joined.vdb"), contents(folder_ / (name + ".vdb")))
            << name << " in " << count << " parts";
      }
    }
  }
}

TEST_F(Program, PartsOfTheFieldsOfAnEnvelopeAreRefusedWhereTheyCannotBe) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  const std::string envelope = "envelope cube.t4d --voxel-size 2 --part ";
  EXPECT_EQ(run("envelope cube.t4d --voxel-size 2 --most-parts").value(), json({{"parts", 2}}));
  const std::string surface = "the surface is that of the whole motion";
  for (const char* option : {"-o no.ply", "--html no.html", "--exact", "--outside", "--center",
                             "--inflate 1", "--simplify 9"}) {
    misused("envelope cube.t4d --visits no.vdb --part 1/2 " + std::string(option), surface);
  }
  misused(envelope + "1/2", "give --visits, --dwell, --first or --last");
  misused(envelope + "1/3 --visits no.vdb",
          "--part: there are 2 blocks of 8 planes along x, too few for 3 parts");
  // A part needs its share of the memory.
  const std::string fine = "envelope cube.t4d --voxel-size 0.5 --max-memory 0.005 --dwell ";
  refuses(fine + "no.vdb", "0.62 fits, and so may parts of them");
  refuses(fine + "no.vdb", "or --part K/N");
  EXPECT_EQ(run(fine + "fine.vdb --part 3/6").exitCode, 0);

  for (const char* part : {"1/2", "2/2"}) {
    const std::string name = fmt::format("-{}.vdb", part[0]);
    ASSERT_EQ(run(envelope + part + " --visits v" + name + " --dwell d" + name).exitCode, 0);
  }
  ASSERT_EQ(run("envelope cube.t4d --voxel-size 2 --visits v.vdb").exitCode, 0);
  refuses("join v-2.vdb -o no.vdb", "v-2.vdb: part 1 of 2 is missing");
  refuses("join v-1.vdb v-2.vdb v-1.vdb -o no.vdb", "part 1 of 2 is given twice, also as v-1.vdb");
  refuses("join v-1.vdb d-2.vdb -o no.vdb",
          "d-2.vdb: is of another run: its field is dwell, and that of v-1.vdb is visits");
  refuses("join v-1.vdb v.vdb -o no.vdb", "v.vdb: is not a part of a field");
  ASSERT_EQ(run(std::string(kPaper) + " --steps 3").exitCode, 0);
  ASSERT_EQ(run(envelope + "2/2 --visits other.vdb").exitCode, 0);
  refuses("join v-1.vdb other.vdb -o no.vdb", "other.vdb: is of another run: its input's ");
  write("cut.vdb", contents(folder_ / "v-2.vdb").substr(0, 900));
  refuses("join v-1.vdb cut.vdb -o no.vdb", "cut.vdb: is cut off");
  std::string flipped = contents(folder_ / "v-2.vdb");
  flipped[flipped.size() - 9] ^= 1;
  write("flipped.vdb", flipped);
  refuses("join v-1.vdb flipped.vdb -o no.vdb", "flipped.vdb: is damaged, or was changed");
  misused("join v-1.vdb v-2.vdb", "--output is required");
  misused("join v-1.vdb v-2.vdb -o no.t4d", "does not end with .vdb");
  misused("join v-1.vdb cube.t4d -o no.vdb", "not joined with other files");
  misused("join v-1.vdb v-2.vdb --manifest -o no.t4dm", "is for meshes (.t4d)");
  misused("join v-1.vdb v-2.vdb -o v-1.vdb", "is an input of this run");
  EXPECT_FALSE(fs::exists(folder_ / "no.vdb"));
}

TEST_F(Program, EnvelopeOfSeveralBodiesIsOfAllOrOfEach) {
  ASSERT_EQ(run("sweep fx/two-boxes.obj -m fx/paper-translation.json -o boxes.t4d").exitCode, 0);
  const json two = run("envelope boxes.t4d --voxel-size 1 --json").value();
  EXPECT_EQ(two["components"], 2);
  // Two cubes of side 2 that overlap by half, as bodies.
  write("two.obj",
        "o a\n" + boxText({0, 0, 0}, {2, 2, 2}) + "o b\n" + boxText({1, 0, 0}, {3, 2, 2}));
  ASSERT_EQ(
      run("sweep two.obj --bodies object -m fx/paper-translation.json -o bodies.t4d").exitCode, 0);
  const json all = run("envelope bodies.t4d --voxel-size 1 --json").value();
  EXPECT_EQ(all["components"], 1);
  EXPECT_EQ(all["bodies"].size(), 1U);
  const json each = run("envelope bodies.t4d --voxel-size 1 --each --json -o each.obj").value();
  ASSERT_EQ(each["bodies"].size(), 2U);
  EXPECT_EQ(each["components"], 2);
  EXPECT_NEAR(all["volume"].get<double>(), 3 * 2 * 66, 1e-3);
  EXPECT_NEAR(each["volume"].get<double>(), 2 * 2 * 2 * 66, 1e-3);
  EXPECT_NEAR(all["visits_volume"].get<double>(), 2 * 2 * 2 * 66, 1e-8);
  const json one = run("envelope bodies.t4d --voxel-size 1 --body b --json").value();
  EXPECT_EQ(one["volume"], each["bodies"][1]["volume"]);
}

TEST_F(Program, EnvelopeWritesAFilePerBody) {
  const std::string motion = " -m fx/paper-translation.json --body ";
  ASSERT_EQ(run("sweep fx/cube.obj" + motion + "arm_1 -o 1.t4d").exitCode, 0);
  ASSERT_EQ(run("sweep fx/two-boxes.obj" + motion + "arm_2 -o 2.t4d").exitCode, 0);
  ASSERT_EQ(run("merge 1.t4d 2.t4d -o arm.t4d").exitCode, 0);
  for (const std::string how : {"", "--outside", "--inflate 1", "--simplify 100"}) {
    const json made =
        run("envelope arm.t4d --voxel-size 2 --each --json -o 'link-{body}.stl' " + how).value();
    ASSERT_EQ(made["bodies"].size(), 2U);
    for (int i = 0; i < 2; ++i) {
      const json& body = made["bodies"][i];
      EXPECT_EQ(body["file"], fmt::format("link-arm_{}.stl", i + 1));
      ASSERT_EQ(run("sweep " + body["file"].get<std::string>() +
                    " -m fx/paper-translation.json -o again.t4d")
                    .exitCode,
                0);
      const json read = run("slice again.t4d --time 0 --json").value();
      EXPECT_EQ(read["triangles"], body["triangles"]);
      EXPECT_NEAR(read["volume"].get<double>() / body["volume"].get<double>(), 1, 1e-5) << how;
    }
  }
  const std::string each = "envelope arm.t4d --voxel-size 2 --each -o ";
  write("own-arm_2.stl", "not of t4d");
  cannot(each + "'own-{body}.stl'", "own-arm_2.stl: exists and was not written by t4d");
  EXPECT_FALSE(fs::exists(folder_ / "own-arm_1.stl"));
  misused(each + "'{body}/a.stl'", "must be in the name of the file");
  misused("envelope arm.t4d -o '{body}.stl'", "needs --each");
}

TEST_F(Program, EnvelopeRefusesWhatItCannotDo) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  refuses("envelope cube.t4d --voxel-size 0.001 -o no.ply",
          "needs about 6019.20 GB of memory, more than the limit of 4.00 GB; 0.039 fits");
  refuses("envelope cube.t4d --voxel-size 0.05 --visits no.vdb", "0.065 fits");
  refuses("envelope cube.t4d --from 70 -o no.ply", "the mesh lasts from time 0 to 64");
  misused("envelope cube.t4d --from 3 --to 2", "--from 3 is not before --to 2");
  misused("envelope cube.t4d --visits no.txt", "does not end with .vdb");
  misused("envelope cube.t4d --visits no.vdb --dwell no.vdb", "two outputs are the same file");
  misused("envelope cube.t4d --each --visits no.vdb", "fields are of all bodies together");
  misused("envelope cube.t4d --exact --voxel-size 1", "--exact");
  EXPECT_FALSE(fs::exists(folder_ / "no.ply"));
  EXPECT_FALSE(fs::exists(folder_ / "no.vdb"));
}

/// Nodes of an animation follow curves, so poses do not tell where they are between two.
TEST_F(Program, PosesOfAnAnimationDoNotTellItsMotion) {
  ASSERT_EQ(run("sweep fx/cube.obj --motion fx/skew-axis.json -o screw.t4d").exitCode, 0);
  ASSERT_EQ(run("flipbook screw.t4d -n 3 --rigid -o moving.glb").exitCode, 0);
  ASSERT_EQ(run("sweep moving.glb -o curve.t4d").exitCode, 0);
  ASSERT_EQ(run("transform curve.t4d --move 100 0 0 -o far.t4d").exitCode, 0);
  // glTF is in metres.
  const auto boundOf = [&](const std::string& arguments) {
    return run("envelope --json " + arguments).value().at("chord_bound");
  };
  EXPECT_GT(boundOf("screw.t4d --voxel-size 4"), 0);
  EXPECT_TRUE(boundOf("curve.t4d --voxel-size 0.004").is_null());
  EXPECT_TRUE(boundOf("far.t4d --voxel-size 0.004").is_null());
  EXPECT_EQ(run("envelope curve.t4d --voxel-size 0.004 --outside").exitCode, 3);
  const auto pair = [&](const std::string& files) {
    return run("collide --ignore-units --json " + files).value().at("pairs").at(0);
  };
  EXPECT_TRUE(pair("curve.t4d far.t4d").at("chord_bound").is_null());
  EXPECT_TRUE(pair("screw.t4d far.t4d").at("chord_bound").is_null());
  EXPECT_FALSE(pair("screw.t4d screw.t4d").at("chord_bound").is_null());
  const json resolved = run("resolve far.t4d screw.t4d --ignore-units --json -o out.t4d").value();
  EXPECT_TRUE(resolved.at("chord_bound").is_null());
}

TEST_F(Program, EnvelopeStatesHowFarTheMeshIsFromTheMotion) {
  ASSERT_EQ(run("sweep fx/cube.obj -m fx/skew-axis.json --steps 6 -o turning.t4d").exitCode, 0);
  ASSERT_EQ(run("sweep fx/cube.obj -m fx/rest.json -o still.t4d").exitCode, 0);
  ASSERT_EQ(run("transform still.t4d --move 500 0 0 -o far.t4d").exitCode, 0);
  const json pair = run("collide turning.t4d far.t4d --ignore-units --json").value()["pairs"][0];
  const json near = run("envelope turning.t4d --voxel-size 1 --json").value();
  EXPECT_GT(near["chord_bound"].get<double>(), 0);
  EXPECT_EQ(near["chord_bound"], pair["chord_bound"]);
  EXPECT_EQ(near["outside"], false);
  EXPECT_TRUE(near["outside_by"].is_null());
  EXPECT_EQ(run("envelope still.t4d --json").value()["chord_bound"], 0);
  // Rounded coordinates are beside the motion, too.
  ASSERT_EQ(run("compress far.t4d --precision float32 -o single.t4d").exitCode, 0);
  const double rounding = run("envelope single.t4d --voxel-size 1 --json").value()["chord_bound"];
  EXPECT_GT(rounding, 0x1p-24 * 500);
  EXPECT_LT(rounding, 1e-3);
  const json rounded = run("collide turning.t4d single.t4d --ignore-units --json").value();
  EXPECT_NEAR(rounded["pairs"][0]["chord_bound"], double(near["chord_bound"]) + rounding, 1e-12);
  EXPECT_THAT(run("envelope turning.t4d --voxel-size 1").out, testing::HasSubstr("of the motion"));
  for (const std::string format : {"ply", "stl", "glb"}) {
    const Finished made =
        run("envelope turning.t4d --voxel-size 1 --outside --json -o out2." + format);
    EXPECT_EQ(made.exitCode, 0) << made.err;
    const json outside = made.value();
    EXPECT_GT(outside["volume"], near["volume"]);
    EXPECT_GT(outside["outside_by"], outside["chord_bound"]);
    EXPECT_EQ(outside["self_intersections"], 0);
    EXPECT_EQ(run("mend out2." + format + " -o again.ply --json").value()["changes"].size(), 0U);
  }
  EXPECT_THAT(run("envelope turning.t4d --voxel-size 1 --outside").out,
              testing::HasSubstr("contains the motion for certain"));
  misused("envelope turning.t4d --outside --exact", "--outside");
  misused("envelope turning.t4d --inflate 1 --exact", "--inflate");
  // Steiner's formula for a cube of side 20.
  const auto volumeWithin = [](double r) {
    const double pi = std::acos(-1);
    return 8000 + 2400 * r + 60 * pi * r * r + 4 * pi / 3 * r * r * r;
  };
  const json inflated = run("envelope still.t4d --inflate 2 --voxel-size 0.5 --json").value();
  EXPECT_EQ(inflated["inflate"], 2);
  EXPECT_GT(inflated["volume"], volumeWithin(2));
  EXPECT_LT(inflated["volume"], volumeWithin(inflated["outside_by"]));
  ASSERT_EQ(run("sweep fx/cube.obj -m fx/skew-axis.json --backend voxel4d --voxel-size 4 "
                "--frames 3 -o voxels.t4d")
                .exitCode,
            0);
  const Finished unknown = run("envelope voxels.t4d --voxel-size 1 --outside --json");
  EXPECT_EQ(unknown.exitCode, 3);
  EXPECT_THAT(unknown.err, testing::HasSubstr("lost: it is certain for the mesh as it is"));
  EXPECT_TRUE(unknown.value()["chord_bound"].is_null());
  EXPECT_TRUE(unknown.value()["outside_by"].is_null());
}

TEST_F(Program, EnvelopeOfAThinSheetSaysWhatElseFindsIt) {
  write("sheet.obj", boxText({0, 0, 0}, {300, 200, 0.002}));
  ASSERT_EQ(run("sweep sheet.obj -m fx/rest.json -o sheet.t4d").exitCode, 0);
  const Finished none = run("envelope sheet.t4d --voxel-size 1 -o no.ply");
  EXPECT_EQ(none.exitCode, 1);
  EXPECT_THAT(none.err, testing::HasSubstr("0.0005 may find it, but takes "));
  EXPECT_THAT(none.err, testing::HasSubstr("--exact or --outside, which need no voxels as small"));
  EXPECT_NEAR(run("envelope sheet.t4d --exact --json").value()["volume"].get<double>(), 120, 1e-6);
  EXPECT_EQ(run("envelope sheet.t4d --outside --voxel-size 3 --json").value()["components"], 1);
}

}  // namespace
}  // namespace t4d::tools
