#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <sys/stat.h>

#include "tools/t4d/tests/program.h"

/// Files that are never overwritten, and outputs that cannot be written.
namespace t4d::tools {
namespace {

/// Every verb that writes files under names of its own.
TEST_F(Program, FilesOfOthersInAnOutputFolderAreNeverTouched) {
  ASSERT_EQ(run("sweep fx/cube.obj -m fx/rest.json --caps cone -o cube.t4d").exitCode, 0);
  writeScript("backend", "cp ../cube.t4d \"$3\"");
  const std::string fixtures = T4D_FIXTURES_PROGRAM;
  struct Writer {
    std::string command;  ///< with the folder at its end
    std::string name;     ///< a file that it writes there
    bool again = true;    ///< its own files are replaced without --force
  };
  const std::string grids = " --voxel-size 4 --frames 2 -o ";
  const std::vector<Writer> writers = {
      {"frames cube.t4d --count 2 --format ply -o ", "frame_0001.ply"},
      {"frames cube.t4d --count 2 --format stl --center -o ", "frame_0001.stl"},
      {"frames cube.t4d --count 2 --format off -o ", "frame_0000.off"},
      {"frames cube.t4d --count 2 --format obj -o ", "manifest.json"},
      {"frames cube.t4d --count 2 --format glb -o ", "frame_0000.glb"},
      {"frames cube.t4d --count 2 --format gltf -o ", "frame_0001.gltf"},
      {"frames cube.t4d --count 2 --format vtp -o ", "frames.pvd"},
      {"frames cube.t4d --count 2 --format vdb --voxel-size 4 -o ", "manifest.json"},
      {"rasterize cube.t4d" + grids, "frame_0001.vdb"},
      {"voxelize fx/cube.obj -m fx/rest.json" + grids, "frame_0000.vdb"},
      {"track cube.t4d --frames 2 --ctc ", "mask001.tif"},
      {"track cube.t4d --frames 2 --ctc ", "res_track.txt"},
      {"view cube.t4d -o ", "cube.t4d"},
      {"view cube.t4d -o ", "index.html"},
      {"compare fx/cube.obj -m fx/rest.json --voxel-size 4 --frames 2 --keep ", "cube-voxel4d.t4d"},
      {"conform copy ", "valid/one-simplex.t4d", false},
      {"conform backends --backend-program ./backend --case cube-at-rest --keep ",
       "cube-at-rest.obj"},
      {"conform reader --reader true --only valid/one-simplex --keep ", "valid/one-simplex.t4d"},
      {"conform writer --writer true --only plain/one-simplex --keep ", "plain/one-simplex.json"},
      {"fixtures ", "cube.obj"},
  };
  int number = 0;
  for (const auto& [command, name, again] : writers) {
    SCOPED_TRACE(command + name);
    const std::string folder = "folder-" + std::to_string(++number);
    const auto writeTo = [&](const std::string& where) {
      return command == "fixtures " ? shell(fixtures + " " + where + " > log 2>&1")
                                    : run(command + where).exitCode;
    };
    const int done = writeTo(folder);
    if (again) {
      EXPECT_EQ(writeTo(folder), done);
    }
    const auto isRefused = [&](const std::string& where) {
      const int code = writeTo(where);
      EXPECT_TRUE(code == 1 || code == 2) << code;
    };
    // A file of somebody else with such a name, a link out of the folder, and one to nowhere.
    for (const std::string kind : {"file", "link", "dangling"}) {
      SCOPED_TRACE(kind);
      const fs::path into = folder_ / (folder + "-" + kind);
      fs::create_directories((into / name).parent_path());
      write("mine", "mine");
      if (kind == "file") std::ofstream(into / name) << "mine";
      if (kind == "link") fs::create_symlink(folder_ / "mine", into / name);
      if (kind == "dangling") fs::create_symlink(folder_ / "nothing", into / name);
      isRefused(into.filename());
      EXPECT_EQ(contents(folder_ / "mine"), "mine");
      EXPECT_FALSE(fs::exists(folder_ / "nothing"));
      EXPECT_EQ(fs::is_symlink(into / name), kind != "file");
      if (kind == "file") {
        EXPECT_EQ(contents(into / name), "mine");
      }
    }
    // The same holds in a folder that was written before.
    fs::remove(folder_ / folder / name);
    fs::create_directories((folder_ / folder / name).parent_path());
    fs::create_symlink(folder_ / "mine", folder_ / folder / name);
    const int code = writeTo(folder + (command.starts_with("conform copy") ? " --force" : ""));
    EXPECT_NE(code, done == 0 ? 0 : -1);
    EXPECT_EQ(contents(folder_ / "mine"), "mine");
    EXPECT_TRUE(fs::is_symlink(folder_ / folder / name));
  }
}

TEST_F(Program, ASiteKeepsFilesThatItsPageDoesNotList) {
  ASSERT_EQ(run("sweep fx/cube.obj -m fx/rest.json --caps cone -o cube.t4d").exitCode, 0);
  ASSERT_EQ(run("sweep fx/torus.obj -m fx/rest.json --caps cone -o torus.t4d").exitCode, 0);
  ASSERT_EQ(run("view cube.t4d -o site").exitCode, 0);
  write("site/torus.t4d", "mine");
  misused("view cube.t4d torus.t4d -o site", "torus.t4d: exists and was not written by t4d");
  EXPECT_EQ(contents(folder_ / "site/torus.t4d"), "mine");
  fs::remove(folder_ / "site/torus.t4d");
  EXPECT_EQ(run("view cube.t4d torus.t4d -o site").exitCode, 0);
  // Files that the page lists are replaced.
  ASSERT_EQ(run("sweep fx/torus.obj -m fx/rest.json --steps 2 --caps cone -o torus.t4d").exitCode,
            0);
  EXPECT_EQ(run("view torus.t4d cube.t4d -o site").exitCode, 0);
  EXPECT_EQ(contents(folder_ / "site/torus.t4d"), contents(folder_ / "torus.t4d"));
  // A page with its files inside lists none beside it.
  fs::create_directory(folder_ / "page");
  ASSERT_EQ(run("view cube.t4d -o page/index.html").exitCode, 0);
  write("page/cube.t4d", "mine");
  misused("view cube.t4d -o page", "cube.t4d: exists");
  EXPECT_EQ(contents(folder_ / "page/cube.t4d"), "mine");
  // A link to the file itself stays as it is.
  fs::remove(folder_ / "page/cube.t4d");
  fs::create_symlink("../cube.t4d", folder_ / "page/cube.t4d");
  EXPECT_EQ(run("view cube.t4d -o page").exitCode, 0);
  EXPECT_TRUE(fs::is_symlink(folder_ / "page/cube.t4d"));
  // A file that was in the folder before is not the page's, though the page shows it.
  fs::create_directory(folder_ / "own");
  fs::copy(folder_ / "cube.t4d", folder_ / "own/torus.t4d");
  ASSERT_EQ(run("view own/torus.t4d -o own").exitCode, 0);
  misused("view torus.t4d -o own", "torus.t4d: exists and was not written by t4d");
  EXPECT_EQ(contents(folder_ / "own/torus.t4d"), contents(folder_ / "cube.t4d"));
  // A copy stays one, also when it is shown from there.
  ASSERT_EQ(run("view site/cube.t4d site/torus.t4d -o site").exitCode, 0);
  EXPECT_EQ(run("view torus.t4d -o site").exitCode, 0);
  // Nothing waits for a pipe.
  fs::create_directory(folder_ / "pipes");
  ASSERT_EQ(::mkfifo((folder_ / "pipes/index.html").c_str(), 0600), 0);
  misused("view cube.t4d -o pipes", "index.html: exists and was not written by t4d");
}

TEST_F(Program, FullDiskAndUnwritablePathsAreErrors) {
  cannot("sweep fx/bolt.obj -m fx/screw-in.json -o /dev/full", "No space left on device");
  ASSERT_EQ(run(kPaper).exitCode, 0);
  for (const char* verb : {"slice cube.t4d --time 1", "flipbook cube.t4d --frames 3"}) {
    cannot(std::string(verb) + " -o nowhere/out.glb", "nowhere/out.glb");
  }
  fs::create_symlink("/dev/full", folder_ / "full.stl");
  cannot("slice cube.t4d --time 1 -o full.stl", "No space left on device");
  cannot("sweep fx/cube.obj -m fx/rest.json -o nowhere/out.t4d", "there is no folder nowhere");
  fs::create_directory(folder_ / "folder.t4d");
  cannot("sweep fx/cube.obj -m fx/rest.json -o folder.t4d", "is a folder");
  cannot("compare cube.t4d cube.t4d --slices 1 --html nowhere/page.html", "nowhere/page.html");
  fs::create_symlink("/dev/full", folder_ / "full.vdb");
  cannot("envelope cube.t4d --voxel-size 4 --visits full.vdb", "No space left on device");
  misused("sweep fx/cube.obj -m fx/rest.json -o ''", "--output: the name is empty");
  misused("slice cube.t4d --time 1 -o ''", "--output: the name is empty");
}

TEST_F(Program, AFieldIsWrittenThroughALink) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  fs::create_symlink("real.vdb", folder_ / "link.vdb");
  ASSERT_EQ(run("envelope cube.t4d --voxel-size 4 --visits link.vdb").exitCode, 0);
  EXPECT_TRUE(fs::is_symlink(folder_ / "link.vdb"));
  EXPECT_GT(fs::file_size(folder_ / "real.vdb"), 0U);
}

TEST_F(Program, OutputsThatCannotBeAreRefusedAtOnce) {
  const std::string sweep = "sweep fx/cube.obj -m fx/rest.json -o ";
  cannot(sweep + "/dev/stdout", "is the standard output");
  cannot(sweep + "missing/out.t4d", "there is no folder missing");
  fs::create_symlink("b.t4d", folder_ / "a.t4d");
  fs::create_symlink("a.t4d", folder_ / "b.t4d");
  cannot(sweep + "a.t4d", "Too many levels of symbolic links");
  fs::create_symlink("real.t4d", folder_ / "link.t4d");
  EXPECT_EQ(run(sweep + "link.t4d").exitCode, 0);
  EXPECT_TRUE(fs::is_symlink(folder_ / "link.t4d"));
  EXPECT_EQ(run("info real.t4d").exitCode, 0);
  // A pipe that is not the standard output.
  EXPECT_EQ(shell("mkfifo pipe && (cat pipe > piped.t4d & $t4d " + sweep + "pipe > log; wait)"), 0);
  EXPECT_EQ(run("validate piped.t4d").exitCode, 0);
}

TEST_F(Program, TheStandardOutputTakesAMesh) {
  EXPECT_EQ(shell(std::string("$t4d ") + kPaper +
                  " && $t4d sweep fx/paper-cube.obj -m "
                  "fx/paper-translation.json -o - > piped.t4d && cmp cube.t4d piped.t4d"),
            0);
  misused("sweep fx/cube.obj -m fx/rest.json -o - --json", "--json");
  EXPECT_EQ(run(std::string(kPaper) + " --quiet").out, "");
  EXPECT_NE(run("info cube.t4d --quiet").out, "");
  EXPECT_EQ(shell("$t4d du cube.t4d > du.txt && $t4d cat cube.t4d --slab 0 > cat.txt"), 0);
  EXPECT_NE(contents(folder_ / "du.txt").find("CONN"), std::string::npos);
  const std::string text = contents(folder_ / "cat.txt");
  EXPECT_EQ(
      text.substr(0, text.find('\n')),
      "slab 0 of 'paper-cube': time 0 to 0, 14 vertices (0 lower, 14 upper, 0 means), 24 cells");
  misused("sweep fx/cube.obj --moton fx/rest.json -o out.t4d", "did you mean --motion?");
}

TEST_F(Program, UnwritableOutputsAreFoundBeforeTheWork) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  for (const std::string arguments :
       {"collide cube.t4d cube.t4d -o no/a.glb", "collide cube.t4d cube.t4d --html no/a.html",
        "envelope cube.t4d --exact -o no/a.obj", "quality cube.t4d -o no/a.t4d",
        "resolve cube.t4d cube.t4d -o no/a.t4d"}) {
    const Finished done = run(arguments);
    EXPECT_EQ(done.exitCode, 1) << arguments;
    EXPECT_THAT(done.err, testing::HasSubstr("there is no folder no")) << arguments;
    EXPECT_EQ(done.out, "") << arguments;
  }
}

}  // namespace
}  // namespace t4d::tools
