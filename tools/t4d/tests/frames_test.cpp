#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "tools/t4d/tests/program.h"

/// `t4d frames`, `flipbook` and `measure`: many times at once.
namespace t4d::tools {
namespace {

TEST_F(Program, FramesAreNumberedFilesWithAManifest) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  const auto said = run("frames cube.t4d --count 5 --format ply --light -o out --json").value();
  EXPECT_EQ(said["frames"], 5);
  EXPECT_EQ(said["triangles"], 5 * 24);
  EXPECT_EQ(said["manifest"], "out/manifest.json");
  EXPECT_TRUE(fs::exists(folder_ / "out/frame_0004.ply"));
  EXPECT_TRUE(fs::exists(folder_ / "out/manifest.json"));
  EXPECT_EQ(run("frames cube.t4d --times 1:2:3 -o out/a_%02d.vtp").exitCode, 0);
  EXPECT_TRUE(fs::exists(folder_ / "out/a_02.vtp"));
  EXPECT_TRUE(fs::exists(folder_ / "out/a.pvd"));
  EXPECT_TRUE(fs::exists(folder_ / "out/a.manifest.json"));
  const Finished fewer = run("frames cube.t4d --count 4 --format ply -o out");
  EXPECT_EQ(fewer.exitCode, 1);
  EXPECT_THAT(fewer.err,
              testing::HasSubstr("out: the folder has frame_0004.ply, which would pass"));
  EXPECT_EQ(run("frames cube.t4d --count 2 --format stl --attributes -o lossy").exitCode, 3);
  for (const char* wrong : {"--count 2 --format png -o a", "--count 2 --format vdb -o a",
                            "--count 2 --format ply -o a%d.obj", "--count 0 -o a",
                            "--count 2 --times 1:2:2 -o a", "--count 2 -o a_%d.xyz"}) {
    EXPECT_EQ(run(std::string("frames cube.t4d ") + wrong).exitCode, 2) << wrong;
  }
  EXPECT_THAT(run("frames cube.t4d --count 2 --format vdb -o a").err,
              testing::HasSubstr("--format vdb needs --voxel-size"));
  EXPECT_EQ(run("frames cube.t4d --count 2 --format vdb --voxel-size 1 --light -o a").exitCode, 2);
  EXPECT_EQ(run("frames cube.t4d --count 2 --voxel-size 1 -o a").exitCode, 2);
  EXPECT_EQ(run("frames cube.t4d --times 60:70:3 -o a").exitCode, 4);
  EXPECT_FALSE(fs::exists(folder_ / "a"));
  ASSERT_EQ(run("frames cube.t4d --count 2 --format vdb --voxel-size 1 -o grids").exitCode, 0);
  EXPECT_TRUE(fs::exists(folder_ / "grids/frame_0001.vdb"));
  // The manifest is that of the other formats, of the same solids.
  ASSERT_EQ(run("frames cube.t4d --count 2 --format ply -o meshes").exitCode, 0);
  json ofGrids = json::parse(contents(folder_ / "grids/manifest.json"));
  json ofMeshes = json::parse(contents(folder_ / "meshes/manifest.json"));
  ASSERT_EQ(ofGrids["frames"].size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    auto& grid = ofGrids["frames"][i];
    auto& mesh = ofMeshes["frames"][i];
    EXPECT_EQ(grid["file"], "frame_000" + std::to_string(i) + ".vdb");
    EXPECT_EQ(grid["bytes"], fs::file_size(folder_ / "grids" / grid["file"].get<std::string>()));
    EXPECT_NEAR(grid["volume"].get<double>(), mesh["volume"].get<double>(), 1e-12);
    for (const char* other : {"file", "bytes", "vertices", "triangles", "volume"}) {
      grid[other] = mesh[other] = nullptr;
    }
  }
  EXPECT_EQ(ofGrids, ofMeshes);
  fs::rename(folder_ / "cube.t4d", folder_ / "c_1.obj");
  EXPECT_EQ(run("frames c_1.obj --count 2 -o c_%d.obj").exitCode, 2);
}

TEST_F(Program, MeasuresASolidOverTime) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  const json samples = run("measure cube.t4d --frames 3 --json").value()["samples"];
  ASSERT_EQ(samples.size(), 3U);
  for (const json& sample : samples) {
    EXPECT_NEAR(sample["volume"].get<double>(), 8000, 1e-8);
    EXPECT_NEAR(sample["area"].get<double>(), 2400, 1e-8);
    EXPECT_EQ(sample["components"], 1);
    EXPECT_EQ(sample["genus"], 0);
  }
  write("times.csv", "frame;time\n1;60\n2;30\n\n# a comment\n3;0\n");
  ASSERT_EQ(run("measure cube.t4d --times-file times.csv -o volumes.csv --html page.html").exitCode,
            0);
  const std::string table = contents(folder_ / "volumes.csv");
  EXPECT_TRUE(table.starts_with("time,volume,area,cx,cy,cz,components,genus")) << table;
  EXPECT_EQ(std::ranges::count(table, '\n'), 4);
  EXPECT_THAT(table, testing::HasSubstr("\n60,"));
  EXPECT_THAT(contents(folder_ / "page.html"), testing::HasSubstr("<svg"));
  ASSERT_EQ(run("measure cube.t4d --frames 4 -o volume.svg").exitCode, 0);
  EXPECT_THAT(contents(folder_ / "volume.svg"),
              testing::StartsWith("<svg xmlns=\"http://www.w3.org/2000/svg\""));
#ifdef T4D_WITH_RSVG
  ASSERT_EQ(run("measure cube.t4d --frames 4 -o all.csv -o all.png -o all.svg").exitCode, 0);
  EXPECT_EQ(contents(folder_ / "all.svg"), contents(folder_ / "volume.svg"));
  EXPECT_THAT(contents(folder_ / "all.csv"), testing::StartsWith("time,"));
  const std::string picture = contents(folder_ / "all.png");
  EXPECT_THAT(picture, testing::StartsWith("\x89PNG"));
  EXPECT_EQ(picture.substr(16, 8), std::string("\0\0\x04\x10\0\0\x02\x08", 8));  // 1040 x 520
#endif
  // Programs that know no variables of style sheets show the colours, too.
  EXPECT_THAT(contents(folder_ / "volume.svg"), testing::Not(testing::HasSubstr("var(")));
  misused("measure cube.t4d -o same.csv -o same.csv", "two outputs are the same file");
  ASSERT_EQ(run("measure cube.t4d --frames 4 -o volumes.json").exitCode, 0);
  EXPECT_EQ(json::parse(contents(folder_ / "volumes.json"))["samples"].size(), 4U);

  // A list that goes back retimes what is played.
  EXPECT_THAT(run("flipbook cube.t4d --times-file times.csv -o back.glb").out,
              testing::HasSubstr("3 frames of time 60 to 0"));
  misused("flipbook cube.t4d --times-file times.csv --morph -o back.glb", "play a stretch of time");
  write("wrong.txt", "0\n1\nx\n");
  refuses("measure cube.t4d --times-file wrong.txt", "wrong.txt:3: found 'x', expected a time");
  write("empty.txt", "# nothing\n");
  refuses("measure cube.t4d --times-file empty.txt", "empty.txt: has no times");
  refuses("measure cube.t4d --times 0:500:2", "time 500 is outside the mesh");
  misused("measure cube.t4d -o out.csv -o out.glb", "does not end with .csv, .json, .svg or .png");
  misused("measure cube.t4d --frames 2 --times 0:1:2", "");
  misused("measure cube.t4d -o cube.t4d", "");
}

TEST_F(Program, AFlipbookPlaysInRealTimeIfItsTimeUnitIsTheSecond) {
  ASSERT_EQ(run(kPaper).exitCode, 0);  // lasts from 0 to 64, without units
  ASSERT_EQ(run("transform cube.t4d --time-unit s -o seconds.t4d").exitCode, 0);
  const auto secondsOf = [&](const std::string& options) {
    const Finished done = run("flipbook " + options + " -o film.glb --json");
    EXPECT_EQ(done.exitCode, 0) << done.err;
    return done.value()["seconds"].get<double>();
  };
  // The fifth frame is shown at second 64, for as long as the others.
  for (const std::string kind : {"", " --rigid", " --morph", " --exact"}) {
    EXPECT_EQ(secondsOf("seconds.t4d --frames 5" + kind), 80) << kind;
    EXPECT_EQ(secondsOf("seconds.t4d --frames 5 --duration 3" + kind), 3) << kind;
    EXPECT_EQ(secondsOf("seconds.t4d --frames 5 --fps 2" + kind), 2.5) << kind;
    EXPECT_EQ(secondsOf("cube.t4d --frames 3" + kind), 0.125) << kind;
  }
  EXPECT_EQ(secondsOf("seconds.t4d --times 64:0:5"), 80);
  EXPECT_EQ(secondsOf("seconds.t4d --times 0,16,32"), 48);
  EXPECT_THAT(run("flipbook seconds.t4d -n 5 -o film.glb").out,
              testing::HasSubstr("plays for 80 s, in real time\n"));
  EXPECT_THAT(run("flipbook seconds.t4d -n 5 --duration 3 -o film.glb").out,
              testing::HasSubstr("plays for 3 s\n"));
  // Neither uneven times nor other units play in real time.
  EXPECT_EQ(secondsOf("seconds.t4d --times 0,16,48"), 0.125);
  EXPECT_EQ(secondsOf("seconds.t4d --times 3,3,3"), 0.125);
  ASSERT_EQ(run("transform cube.t4d --time-unit min -o minutes.t4d").exitCode, 0);
  EXPECT_EQ(secondsOf("minutes.t4d --frames 3"), 0.125);
  // At every second of it is what the mesh is at that time.
  ASSERT_EQ(run("flipbook seconds.t4d --morph -n 5 -o film.glb").exitCode, 0);
  ASSERT_EQ(run("sweep film.glb -o again.t4d").exitCode, 0);
  const auto distances = [&](const std::string& file) {
    std::vector<double> result;
    const Finished done = run("measure " + file + " --times 1,20,63 --json");
    for (const json& sample : done.value()["samples"]) {
      const auto center = sample["centroid"].get<std::array<double, 3>>();
      result.push_back(std::hypot(center[0], center[1], center[2]));
    }
    return result;
  };
  EXPECT_THAT(distances("again.t4d"),
              testing::Pointwise(testing::DoubleNear(1e-4), distances("seconds.t4d")));
  misused("flipbook cube.t4d --duration 0 -o a.glb", "--duration: '0' is not a number above 0");
  misused("flipbook cube.t4d --duration 1 --fps 2 -o a.glb", "--duration");
  write("even.csv", "playback,time\n0,0\n64,64\n");
  misused("flipbook cube.t4d --duration 1 --speed-file even.csv -o a.glb", "--duration: the curve");
}

TEST_F(Program, PlaysCurvesOfTimeAndSpeed) {
  ASSERT_EQ(run(kPaper).exitCode, 0);  // lasts from 0 to 64
  const auto film = [&](const std::string& options) {
    EXPECT_EQ(run("flipbook cube.t4d " + options + " -o film.glb").exitCode, 0) << options;
    return contents(folder_ / "film.glb");
  };
  write("even.csv", "playback,time\n0,0\n64,64\n");
  EXPECT_TRUE(film("--speed-file even.csv --fps 3") == film("--frames 193 --fps 3"));
  // Seconds that begin anywhere.
  write("rows.csv", "playback\ttime\r\n-1.5\t0\r\n\r\n# a comment\r\n5.5\t7\r\n62.5\t64\r\n");
  EXPECT_TRUE(film("--speed-file rows.csv --fps 1") == film("--frames 65 --fps 1"));
  write("twice.csv", "playback speed\n0 2\n0.7 2\n32 2\n");
  EXPECT_TRUE(film("--speed-file twice.csv --fps 10") == film("--frames 321 --fps 10"));
  EXPECT_TRUE(film("--speed-file even.csv") == film("--frames 1537 --fps 24"));

  const auto times = [&](const std::string& curve) {
    write("curve.csv", curve);
    fs::remove_all(folder_ / "frames");
    EXPECT_EQ(run("frames cube.t4d --speed-file curve.csv --fps 2 --format ply -o frames").exitCode,
              0);
    std::vector<double> found;
    const json manifest = json::parse(contents(folder_ / "frames/manifest.json"));
    for (const json& frame : manifest["frames"]) found.push_back(frame["time"]);
    return found;
  };
  const auto frame = [&](int i) {
    return contents(folder_ / "frames" / ("frame_000" + std::to_string(i) + ".ply"));
  };
  EXPECT_THAT(times("playback,time\n0,10\n1,50\n2,10\n"), testing::ElementsAre(10, 30, 50, 30, 10));
  EXPECT_EQ(frame(0), frame(4));
  EXPECT_EQ(frame(1), frame(3));
  // The integral of the speed 8 s, then of 16 backwards; the last row lies before the next frame.
  EXPECT_THAT(times("playback,speed\n0,0\n2,16\n2.000001,-16\n2.6,-16\n"),
              testing::ElementsAre(0, 1, 4, 9, 16, testing::DoubleNear(8, 1e-4)));
  EXPECT_THAT(times("playback,time\n3,7\n"), testing::ElementsAre(7));

  const auto refused = [&](const std::string& curve, const std::string& why) {
    write("curve.csv", curve);
    refuses("frames cube.t4d --speed-file curve.csv -o frames", why);
  };
  refused("# none\n", "curve.csv:1: found '', expected the header playback,time or playback,speed");
  refused("\ntime,playback\n0,0\n", "curve.csv:2: found 'time,playback', expected the header");
  refused("playback,time\n", "curve.csv: has no rows");
  refused("playback,time\n0,0\n1,x\n", "curve.csv:3: found 'x', expected a number");
  refused("playback,time\n0,0,5\n", "curve.csv:2: has 3 columns, expected 2");
  refused("playback,time\n0,0\n2,1\n2,5\n", "curve.csv:4: playback 2 follows 2; expected seconds");
  refused("playback,time\n0,60\n10,70\n",
          "curve.csv:3: time 64.04166666666667 at second 4.041666666666667 of playback is outside");
  refused("playback,speed\n0,-1\n1,-1\n", "curve.csv:3: time -0.04166");
  refused("playback,time\n0,0\n1e300,1\n", "at 24 frames a second more than 1000000 frames");
  misused("frames cube.t4d --speed-file even.csv --frames 4 -o frames", "at most 1");
  misused("frames cube.t4d --speed-file even.csv --times-file even.csv -o frames", "at most 1");
  misused("frames cube.t4d --fps 4 -o frames",
          "--fps: needs --speed-file, --velocity or USD files");
  misused("flipbook cube.t4d --speed-file even.csv --rigid -o a.glb", "play a stretch of time");
}

TEST_F(Program, ThereAreSixtyFramesWithoutANumberOfThem) {
  ASSERT_EQ(run("sweep fx/cube.obj -m fx/rest.json -o cube.t4d").exitCode, 0);
  for (const char* verb : {"flipbook cube.t4d -o f.glb", "frames cube.t4d --light -o f",
                           "rasterize cube.t4d --voxel-size 1 -o v"}) {
    const Finished done = run(std::string(verb) + " --json");
    EXPECT_EQ(done.value()["frames"], 60) << done.err;
    EXPECT_THAT(done.err,
                testing::HasSubstr("60 frames, evenly spaced; --frames changes their number"));
  }
  for (const char* named :
       {"flipbook cube.t4d -o f.glb --count 2", "frames cube.t4d -o g -n 2",
        "rasterize cube.t4d --voxel-size 1 -o w --count 2", "frames cube.t4d -o g --frames 2"}) {
    const Finished done = run(std::string(named) + " --json");
    EXPECT_EQ(done.value()["frames"], 2) << named;
    EXPECT_EQ(done.err, "") << named;
  }
}

}  // namespace
}  // namespace t4d::tools
