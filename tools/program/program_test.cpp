#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/paths.h"

/// The program from the user's point of view: its output, its files, its exit codes.
namespace t4d::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct Finished {
  int exitCode = -1;
  std::string out;
  std::string err;
  json value() const { return json::parse(out); }
};

std::string contents(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Each test has its own folder, with all fixtures in it.
class Program : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(testing::TempDir()) /
              ("t4d_program_" + std::string(info->name()) + "_" + std::to_string(::getpid()));
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    ASSERT_EQ(std::system((std::string(T4D_FIXTURES_PROGRAM) + " " + (folder_ / "fx").string() +
                           " > " + (folder_ / "fixtures.log").string())
                              .c_str()),
              0);
  }
  void TearDown() override { fs::remove_all(folder_); }

  Finished run(const std::string& arguments) {
    const std::string command = "cd " + folder_.string() + " && " + T4D_PROGRAM + " " + arguments +
                                " > " + "stdout.txt 2> stderr.txt";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status),
            contents(folder_ / "stdout.txt"), contents(folder_ / "stderr.txt")};
  }

  /// Runs a script in which "$t4d" is the program. Returns the exit code, or -signal if killed.
  int shell(const std::string& script) {
    const std::string command =
        "cd " + folder_.string() + " && t4d=" + T4D_PROGRAM + " && " + script;
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

  fs::path write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }

  /// Invalid input: exit 4, an error that names what and where, and no output file.
  void refuses(const std::string& arguments, const std::string& expected, int exitCode = 4) {
    SCOPED_TRACE(arguments);
    const Finished done = run(arguments);
    EXPECT_EQ(done.exitCode, exitCode) << done.err;
    EXPECT_NE(done.err.find(expected), std::string::npos) << done.err;
    EXPECT_FALSE(fs::exists(folder_ / "out.t4d"));
    EXPECT_FALSE(fs::exists(folder_ / "out.glb"));
    for (const auto& entry : fs::directory_iterator(folder_)) {
      EXPECT_EQ(entry.path().string().find(".part"), std::string::npos) << entry.path();
    }
  }

  /// Wrong usage: exit 2, and the option is named.
  void misused(const std::string& arguments, const std::string& expected) {
    refuses(arguments, expected, 2);
  }

  /// An output that cannot be written: exit 1.
  void cannot(const std::string& arguments, const std::string& expected) {
    refuses(arguments, expected, 1);
  }

  fs::path folder_;
};

constexpr const char* kPaper = "sweep fx/paper-cube.obj -m fx/paper-translation.json -o cube.t4d";

TEST_F(Program, LoadsOpenVdbAndCurlWhenTheyAreUsed) {
  ASSERT_EQ(shell("LD_TRACE_LOADED_OBJECTS=1 $t4d > libraries.txt"), 0);
  const std::string libraries = contents(folder_ / "libraries.txt");
  EXPECT_NE(libraries.find("libstdc++"), std::string::npos);
  EXPECT_EQ(libraries.find("openvdb"), std::string::npos);
  EXPECT_EQ(libraries.find("libcurl"), std::string::npos);
  // A program without its modules says so when it needs one.
  fs::copy_file(T4D_PROGRAM, folder_ / "alone");
  EXPECT_EQ(shell("./alone version > alone.txt"), 0);
  EXPECT_EQ(shell("./alone voxelize fx/cube.obj -m fx/rest.json --voxel-size 2 --frames 2 "
                  "-o out 2> alone.txt"),
            1);
  EXPECT_NE(contents(folder_ / "alone.txt").find("t4d_openvdb.so"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder_ / "out"));
}

TEST_F(Program, PaperCubeEndToEnd) {
  const json swept = run(std::string(kPaper) + " --json").value();
  EXPECT_EQ(swept["vertices"], 4750);
  EXPECT_EQ(swept["tetrahedra"], 21552);
  EXPECT_EQ(swept["steps"], 64);
  EXPECT_EQ(swept["cap_tetrahedra"], json::array({24, 24}));
  EXPECT_TRUE(swept.contains("seconds") && swept.contains("peak_bytes"));

  const json info = run("info cube.t4d --json").value();
  EXPECT_EQ(info["format_version"], "1.0");
  EXPECT_EQ(info["backend"], "mesh4d");
  EXPECT_EQ(info["slabs"], 66);
  EXPECT_EQ(info["vertices"], 4750);
  EXPECT_EQ(info["tetrahedra"], 21552);
  EXPECT_EQ(info["time_begin"], 0);
  EXPECT_EQ(info["time_end"], 64);
  EXPECT_EQ(info["bounds_min"], json::array({-10, -10, -10}));
  EXPECT_EQ(info["bounds_max"], json::array({10, 10, 74}));
  EXPECT_EQ(info["bytes"], fs::file_size(folder_ / "cube.t4d"));
  for (const char* key : {"generator", "length_unit", "time_unit"}) {
    EXPECT_TRUE(info.contains(key));
  }

  const json valid = run("validate cube.t4d --deep --json").value();
  EXPECT_EQ(valid["valid"], true);
  EXPECT_EQ(valid["closed"], true);
  EXPECT_EQ(valid["oriented"], true);
  EXPECT_EQ(valid["vertex_links_ok"], true);
  EXPECT_EQ(valid["components"], 1);
  EXPECT_EQ(valid["degenerate_cells"], 0);
  EXPECT_NEAR(valid["hypervolume"].get<double>(), 512000, 512000 * 1e-9);
  EXPECT_EQ(valid["issues"]["errors"], 0);

  const json slice = run("slice cube.t4d --time 31.5 -o at.glb --json").value();
  EXPECT_EQ(slice["closed"], true);
  EXPECT_NEAR(slice["volume"].get<double>(), 8000, 8e-6);
  EXPECT_EQ(slice["slabs_read"], 1);
  EXPECT_LT(slice["bytes_read"].get<double>(), info["bytes"].get<double>() / 2);
  const json layer = run("slice cube.t4d --time 64 -o at.ply --json").value();
  EXPECT_EQ(layer["vertices"], 14);
  EXPECT_EQ(layer["triangles"], 24);
  EXPECT_NEAR(layer["area"].get<double>(), 2400, 1e-9);
}

TEST_F(Program, DeformationsAreSwept) {
  const json series = run("sweep fx/bending_*.obj --frame-time 0.25 -o series.t4d --json").value();
  // 288 vertices, 864 edges, 576 triangles, 8 steps.
  EXPECT_EQ(series["steps"], 8);
  EXPECT_EQ(series["tetrahedra"],
            14 * 576 * 8 + int(series["cap_tetrahedra"][0]) + int(series["cap_tetrahedra"][1]));
  EXPECT_EQ(series["folds"], json({{"prisms", 0}, {"steps", 0}, {"first", json::array()}}));
  EXPECT_EQ(series["crossings"],
            json({{"pairs", 0}, {"steps", 0}, {"unfinished_steps", 0}, {"first", json::array()}}));
  ASSERT_EQ(run("sweep fx/bending_0.obj fx/bending.pc2 --times 0:2 -o cached.t4d").exitCode, 0);
  for (const char* file : {"series.t4d", "cached.t4d"}) {
    const json judged = run(std::string("validate --deep --json ") + file).value();
    EXPECT_EQ(judged["valid"], true) << file;
    // The bending does not change the volume, nor does the interpolation.
    EXPECT_NEAR(double(judged["hypervolume"]),
                2 * double(run("slice series.t4d --time 0 --json").value()["volume"]), 1e-2);
    const json slice = run("slice " + std::string(file) + " --time 0.5 --json").value();
    EXPECT_EQ(slice["triangles"], 576);
    EXPECT_EQ(slice["closed"], true);
  }
  refuses("sweep fx/bending_[025].obj --frame-time 1 -o out.t4d", "number 1 is missing");
  refuses("sweep fx/bending_0.obj fx/torus.obj --frame-time 1 -o out.t4d", "torus.obj: has ");
  const Finished oneApart = run("sweep fx/bending_*.obj -o one-apart.t4d");
  EXPECT_EQ(oneApart.exitCode, 0);
  EXPECT_THAT(oneApart.err, testing::HasSubstr("frames are taken to be 1 apart"));
  refuses("sweep fx/cube.obj fx/bending.pc2 -o out.t4d", "bending.pc2: has 288 points");
  misused("sweep fx/bending_0.obj -o out.t4d", "--motion is required");
  misused("sweep fx/bending.pc2 fx/bending_0.obj -o out.t4d", "a point cache");
  misused("sweep fx/bending_0.obj fx/bending.pc2 --times 2:1 -o out.t4d", "'2:1' is not A:B");
  misused("sweep fx/bending_0.obj fx/bending.pc2 --steps 3 -o out.t4d", "--rv-min, --steps");
  misused("sweep fx/bending_[01].obj -m fx/rest.json -o out.t4d", "--motion is for one solid");
  misused("sweep fx/cube.obj -m fx/rest.json --between midpoint -o out.t4d",
          "--mask and --between are for --backend voxel4d");
  misused("compare a.t4d b.t4d --between distance", "are for one solid; two .t4d files");
  misused("sweep fx/bending_[01].obj --backend voxel4d --voxel-size 1 -o out.t4d",
          "needs --motion");
}

TEST_F(Program, MotionsAreTablesToo) {
  write("poses.csv", "time,x,y,z\n0,0,0,0\n2,0,0,5\n");
  ASSERT_EQ(run("sweep fx/cube.obj -m poses.csv -o moved.t4d").exitCode, 0);
  const json info = run("info moved.t4d --json").value();
  EXPECT_EQ(info["bodies"][0]["time_end"], 2);
  write("poses.csv", "time,x,y,z\n0,0,0,0\n2,0,0\n");
  refuses("sweep fx/cube.obj -m poses.csv -o out.t4d", "poses.csv:3: has 3 fields");
}

TEST_F(Program, FoldsOfADeformationAreReported) {
  // The solid turns inside out.
  write("in.obj", "v -1 -1 -1\nv 2 0 0\nv 0 2 0\nv 0 0 2\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  write("out.obj", "v 1 1 1\nv -2 0 0\nv 0 -2 0\nv 0 0 -2\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  const Finished done = run("sweep in.obj out.obj --times 1:3 --caps cone -o turned.t4d --json");
  EXPECT_EQ(done.exitCode, 0);
  EXPECT_NE(done.err.find("4 prisms in 1 of 1 steps fold"), std::string::npos) << done.err;
  const json folds = done.value()["folds"];
  EXPECT_EQ(folds["prisms"], 4);
  EXPECT_EQ(folds["first"][0]["time"], json::array({1, 3}));
  EXPECT_EQ(folds["first"][0]["triangle"], 0);
}

TEST_F(Program, CrossingsBetweenTheKeysOfADeformationAreReported) {
  // One tetrahedron of two passes through the other.
  const std::string faces =
      "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\nf 5 7 6\nf 5 6 8\nf 5 8 7\nf 6 7 8\n";
  const std::string still = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
  write("left.obj", still + "v -3 0.1 0.2\nv -2 0.1 0.2\nv -3 1.1 0.2\nv -3 0.1 1.2\n" + faces);
  write("right.obj", still + "v 3 0.1 0.2\nv 4 0.1 0.2\nv 3 1.1 0.2\nv 3 0.1 1.2\n" + faces);
  const Finished done = run("sweep left.obj right.obj --times 0:6 -o through.t4d --json");
  EXPECT_EQ(done.exitCode, 0);
  EXPECT_NE(done.err.find("in 1 of 1 steps meet between keys"), std::string::npos) << done.err;
  const json crossings = done.value()["crossings"];
  EXPECT_GT(crossings["pairs"], 2);
  EXPECT_EQ(crossings["steps"], 1);
  const json& first = crossings["first"][0];
  EXPECT_EQ(first["time"], json::array({0, 6}));
  EXPECT_GE(first["at"], 2);
  EXPECT_LE(first["at"], 4);
  EXPECT_LE(first["triangles"][0], 3);
  EXPECT_GE(first["triangles"][1], 4);
  EXPECT_EQ(done.value()["folds"]["prisms"], 0);
}

TEST_F(Program, WritesEveryFormatAndPlaysTwo) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  for (const char* name : {"a.glb", "a.gltf", "a.stl", "a.ply", "a.obj"}) {
    EXPECT_EQ(run(std::string("slice cube.t4d --time -0 -o ") + name).exitCode, 0) << name;
    EXPECT_GT(fs::file_size(folder_ / name), 100U);
  }
  for (const char* cut : {"--x 1", "--y -2.5", "--z 30", "--hyperplane 1,2,3,-4,5"}) {
    const Finished done = run(std::string("slice cube.t4d -o b.glb --json ") + cut);
    EXPECT_EQ(done.exitCode, 0) << done.err;
    EXPECT_EQ(done.value()["closed"], true);
    EXPECT_GT(done.value()["volume"], 0);
  }
  EXPECT_EQ(run("flipbook cube.t4d --frames 5 -o f.glb --json").value()["frames"], 5);
  EXPECT_EQ(run("flipbook cube.t4d --times 1:2:3 -o f.gltf --json").value()["frames"], 3);
}

TEST_F(Program, LightSlicesAreTheSolidAndAsLargeAsExactOnes) {
  ASSERT_EQ(run("sweep fx/torus.obj -m fx/skew-axis.json --rv-min 0.9 -o torus.t4d").exitCode, 0);
  const auto exact = run("slice torus.t4d --time 0.31 --json").value();
  const auto light = run("slice torus.t4d --time 0.31 --light --json").value();
  EXPECT_EQ(exact["light"], false);
  EXPECT_EQ(exact["distance"], 0);
  EXPECT_EQ(light["light"], true);
  EXPECT_GT(light["distance"], 0);
  EXPECT_EQ(exact["triangles"].get<int>(), 13 * light["triangles"].get<int>());
  EXPECT_NEAR(light["volume"].get<double>() / exact["volume"].get<double>(), 1, 1e-12);
  EXPECT_THAT(run("slice torus.t4d --time 0.31 --light").out,
              testing::HasSubstr("light: the layers' triangles, within "));
  // The triangles of the input, in its order.
  ASSERT_EQ(run("slice torus.t4d --time 0.31 --light -o light.obj").exitCode, 0);
  const auto faces = [&](const char* name) {
    std::string all;
    std::ifstream file(folder_ / name);
    for (std::string line; std::getline(file, line);) {
      if (line.starts_with("f ")) all += line + "\n";
    }
    return all;
  };
  EXPECT_EQ(faces("light.obj"), faces("fx/torus.obj"));

  const auto few = run("flipbook torus.t4d --frames 7 -o light.glb --json").value();
  const auto many = run("flipbook torus.t4d --frames 7 -o exact.glb --exact --json").value();
  EXPECT_EQ(few["triangles"].get<int>(), 7 * light["triangles"].get<int>());
  EXPECT_EQ(few["light"], true);
  EXPECT_EQ(many["light"], false);
  EXPECT_LT(6 * few["bytes"].get<int>(), many["bytes"].get<int>());
  EXPECT_EQ(run("slice torus.t4d --x 0 --light").exitCode, 2);

  // Slabs that are no prisms.
  ASSERT_EQ(run("sweep fx/cube.obj -m fx/rest.json --prism 3 -o three.t4d").exitCode, 0);
  const Finished done = run("slice three.t4d --time 0.5 --light --json");
  EXPECT_EQ(done.exitCode, 0);
  EXPECT_EQ(done.value()["light"], false);
  EXPECT_THAT(done.err,
              testing::HasSubstr("is exact, because its slab does not consist of prisms"));
  EXPECT_THAT(run("flipbook three.t4d -n 3 -o three.glb").err,
              testing::HasSubstr("has exact slices, because a slab does not consist of prisms"));
}

/// Every verb that writes files under names of its own.
TEST_F(Program, FilesOfOthersInAnOutputFolderAreNeverTouched) {
  ASSERT_EQ(run("sweep fx/cube.obj -m fx/rest.json --caps cone -o cube.t4d").exitCode, 0);
  write("backend", "#!/bin/sh\ncp ../cube.t4d \"$3\"\n");
  fs::permissions(folder_ / "backend", fs::perms::owner_all);
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
    // In a folder that was written before, too.
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
  // What the page lists is replaced.
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
  std::ifstream grids(folder_ / "grids/manifest.json");
  std::ifstream meshes(folder_ / "meshes/manifest.json");
  auto ofGrids = nlohmann::json::parse(grids);
  auto ofMeshes = nlohmann::json::parse(meshes);
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
  misused("measure cube.t4d -o out.csv -o out.glb", "not the name of a .csv, .json, .svg or .png");
  misused("measure cube.t4d --frames 2 --times 0:1:2", "");
  misused("measure cube.t4d -o cube.t4d", "");
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

TEST_F(Program, SaysWhichPartsAreLostBetweenFrames) {
  // Plates of 3 voxels that move by 3 of them.
  std::string samples = "raw uint8 8 8 12 3 little\n";
  for (int frame = 0; frame < 3; ++frame) {
    for (int z = 0; z < 12; ++z) {
      samples += std::string(64, z >= 3 * frame && z < 3 * frame + 3 ? '\1' : '\0');
    }
  }
  write("plate.raw", samples);
  const Finished done = run("weave plate.raw --label 1 -o plate.t4d --json");
  EXPECT_EQ(done.exitCode, 0);
  EXPECT_THAT(
      done.err,
      testing::HasSubstr("a part of 192 voxels at (3.5, 3.5, 1) moves by its own width or more"));
  const json lost = done.value()["parts_lost"];
  ASSERT_EQ(lost.size(), 2U);
  EXPECT_EQ(lost[1], json::parse(R"({"frame": 1, "time": 1.0, "point": [3.5, 3.5, 4.0],
                                     "voxels": 192})"));
  EXPECT_EQ(run("weave plate.raw --label 1 --fail-on-lost-parts -o plate.t4d").exitCode, 1);
  EXPECT_TRUE(fs::exists(folder_ / "plate.t4d"));
  EXPECT_EQ(run("weave plate.raw --label 1 --between midpoint -o jumps.t4d").exitCode, 0);
  EXPECT_EQ(run("measure plate.t4d --times 0.5:0.5:1 --json").value()["samples"][0]["components"],
            run("measure jumps.t4d --times 0.5:0.5:1 --json").value()["samples"][0]["components"]);
  const json voxels =
      run("voxelize fx/cube.obj -m fx/paper-voxel.json --voxel-size 0.25 --frames 4 "
          "-o frames --fail-on-lost-parts --json")
          .value();
  EXPECT_EQ(voxels["parts_lost"].size(), 3U);
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

TEST_F(Program, TextureCoordinatesOfCornersComeOutOfLightSlices) {
  // A cube with a texture square on every side, so that corners at one vertex differ, and inside
  // out, so that the sweep turns its triangles over.
  std::ofstream obj(folder_ / "cube.obj");
  for (int i = 0; i < 8; ++i) {
    obj << "v " << (i & 1) << " " << (i >> 1 & 1) << " " << (i >> 2) << "\n";
  }
  obj << "vt 0 0\nvt 0.25 0\nvt 0.25 0.5\nvt 0 0.5\nusemtl wood\n"
         "f 1/1 2/2 4/3 3/4\nf 5/1 7/2 8/3 6/4\nf 1/1 5/2 6/3 2/4\n"
         "f 3/1 4/2 8/3 7/4\nf 1/1 3/2 7/3 5/4\nf 2/1 6/2 8/3 4/4\n";
  obj.close();
  for (const char* step : {"sweep cube.obj -m fx/rest.json --body cube -o a.t4d",
                           "slice a.t4d --time 0.5 --light --attributes -o a.glb",
                           "sweep a.glb -m fx/rest.json --body cube -o b.t4d",
                           "slice b.t4d --time 0.5 --light --attributes -o b.glb",
                           "slice a.t4d --time 0.5 --light --attributes -o a.ply"}) {
    const Finished done = run(step);
    EXPECT_TRUE(done.exitCode == 0 || done.exitCode == 3) << step << done.err;
  }
  EXPECT_EQ(run("info a.t4d --json").value()["details"]["materials"], (json{"", "wood"}));
  const auto bytes = [&](const char* name) {
    std::ifstream file(folder_ / name, std::ios::binary);
    return std::string((std::istreambuf_iterator<char>(file)), {});
  };
  EXPECT_THAT(bytes("a.ply"), testing::HasSubstr("property float uv_corners_5"));
  EXPECT_THAT(bytes("a.glb"), testing::HasSubstr("TEXCOORD_0"));
  EXPECT_EQ(bytes("a.glb"), bytes("b.glb"));
}

TEST_F(Program, NormalsAndColoursAreWrittenOnDemand) {
  ASSERT_EQ(run("sweep fx/two-boxes.obj -m fx/rest.json -o boxes.t4d").exitCode, 0);
  const auto contents = [&](const char* name) {
    std::ifstream file(folder_ / name, std::ios::binary);
    return std::string((std::istreambuf_iterator<char>(file)), {});
  };
  const std::string look = " --normals crease:30 --color body ";
  for (const char* name : {"b.glb", "b.ply", "b.obj", "b.vtp"}) {
    ASSERT_EQ(run("slice boxes.t4d --time 0.5 --light -o " + std::string(name) + look).exitCode, 0);
  }
  EXPECT_THAT(contents("b.glb"), testing::HasSubstr("\"NORMAL\""));
  EXPECT_THAT(contents("b.ply"), testing::HasSubstr("element vertex 48\n"));  // 3 at each corner
  EXPECT_THAT(contents("b.ply"), testing::HasSubstr("property float nz\nproperty uchar red\n"));
  EXPECT_THAT(contents("b.obj"), testing::HasSubstr("vn 0 0 1\n"));
  EXPECT_THAT(contents("b.vtp"), testing::HasSubstr("<PointData Normals=\"Normals\">"));
  // A reader merges the repeated vertices again.
  EXPECT_EQ(run("sweep b.ply -m fx/rest.json -o again.t4d").exitCode, 0);
  EXPECT_EQ(run("sweep b.obj -m fx/rest.json -o again.t4d").exitCode, 0);
  EXPECT_EQ(run("slice boxes.t4d --time 0.5 -o b.stl" + look).exitCode, 3);
  EXPECT_EQ(run("slice boxes.t4d --time 0.5 --normals flat -o b.stl").exitCode, 0);
  EXPECT_EQ(run("slice boxes.t4d --x 0 --color time -o b.ply").exitCode, 2);
  EXPECT_EQ(run("slice boxes.t4d --x 0 --color triangle -o b.ply").exitCode, 0);
  EXPECT_EQ(run("slice boxes.t4d --x 8 --color attribute:heat -o b.ply").exitCode, 4);
  EXPECT_EQ(run("slice boxes.t4d --x 0 --color heat -o b.ply").exitCode, 2);
  EXPECT_EQ(run("slice boxes.t4d --x 0 --quantize 12 -o b.ply").exitCode, 2);
  EXPECT_EQ(run("slice boxes.t4d --x 0 --quantize 17 -o b.glb").exitCode, 2);
  EXPECT_EQ(run("flipbook boxes.t4d -n 2 --rigid --quantize 12 -o b.glb").exitCode, 2);
  EXPECT_EQ(run("flipbook boxes.t4d -n 2 --morph --quantize 16 -o b.glb").exitCode, 2);
  EXPECT_EQ(run("slice boxes.t4d --x 0 --normals crease:200 -o b.ply").exitCode, 2);
}

TEST_F(Program, WritesAndReadsUsd) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  const auto written = run("flipbook cube.t4d --frames 5 -o f.usda --json").value();
  EXPECT_EQ(written["files"], nlohmann::json({"f.usda"}));
  EXPECT_EQ(written["frames"], 5);
  EXPECT_EQ(run("flipbook cube.t4d --frames 5 -o f.usdz").exitCode, 0);
  for (const char* file : {"f.usda", "f.usdz"}) {
    const auto swept = run(std::string("sweep ") + file + " -o again.t4d --json").value();
    EXPECT_EQ(swept["bodies"][0]["name"], "paper-cube");
    EXPECT_EQ(run("validate again.t4d --json").value()["valid"], true);
    // It plays for as long as there are frames after the first.
    EXPECT_NEAR(run("slice again.t4d --time 0.16666666666666666 --json").value()["volume"], 8000,
                1e-2);
  }
  EXPECT_EQ(run("flipbook cube.t4d -n 2 --rigid -o r.usda").exitCode, 0);
  EXPECT_EQ(run("sweep r.usda --tolerance 1 -o again.t4d").exitCode, 0);
  EXPECT_EQ(run("flipbook cube.t4d -n 2 --exact -o e.usda").exitCode, 0);
  misused("flipbook cube.t4d -n 2 --visibility -o f.usda", "--visibility is for glTF");
  misused("flipbook cube.t4d -n 2 --quantize 12 -o f.usda", "--quantize: only .glb and .gltf");
  misused("flipbook cube.t4d -n 2 -o f.usdc", "is not a .glb, .gltf, .usda or .usdz file");
  misused("sweep f.usda --animation x -o a.t4d",
          "--animation and --scene are for an animated glTF");
  refuses("sweep f.usdc -o a.t4d", "f.usdc: no such file");
  std::ofstream(folder_ / "b.usdc") << "PXR-USDC and more";
  refuses("sweep b.usdc -o a.t4d", "usdcat --flatten");
  refuses("sweep b.usdc -m fx/rest.json -o a.t4d", "usdcat --flatten");
  // A solid, at the first frame.
  const Finished still = run("sweep f.usda -m fx/rest.json -o a.t4d");
  EXPECT_EQ(still.exitCode, 3);
  EXPECT_THAT(still.err, testing::HasSubstr("the animation: meshes are as they are at its first"));
  EXPECT_EQ(run("frames cube.t4d -n 3 --fps 12 --format usda -o set").exitCode, 0);
  EXPECT_THAT(contents(folder_ / "set/frames.usda"),
              testing::HasSubstr("timeCodesPerSecond = 12\n"));
  EXPECT_EQ(run("slice cube.t4d --time 1 -o one.usdz").exitCode, 0);
  EXPECT_EQ(run("sweep one.usdz -m fx/rest.json -o a.t4d").exitCode, 0);
}

TEST_F(Program, ListsWhatItDoesNotTakeOfGltf) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  ASSERT_EQ(run("slice cube.t4d --time 0 -o still.glb").exitCode, 0);
  ASSERT_EQ(run("flipbook cube.t4d --frames 2 -o moving.glb").exitCode, 0);
  const std::string lost = "t4d: lost: the animation of 2 nodes: the mesh is as it is at rest\n";
  for (const std::string verb :
       {"sweep $ -m fx/rest.json -o a.t4d",
        "voxelize $ -m fx/rest.json --voxel-size 4 --frames 2 -o a",
        "compare $ -m fx/rest.json --voxel-size 4 --frames 2 --caps graded"}) {
    const auto with = [&](const char* model) {
      return run(std::string(verb).replace(verb.find('$'), 1, model));
    };
    const Finished still = with("still.glb");
    EXPECT_EQ(still.exitCode, 0) << verb << still.err;
    EXPECT_EQ(still.err, "");
    const Finished moving = with("moving.glb");
    EXPECT_EQ(moving.exitCode, 3) << verb << moving.err;
    EXPECT_THAT(moving.err, testing::HasSubstr(lost));
  }
}

TEST_F(Program, RecoversWhatIsWhole) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  const std::string whole = contents(folder_ / "cube.t4d");
  const Finished copied = run("recover cube.t4d -o out.t4d");
  EXPECT_EQ(copied.exitCode, 0) << copied.err;
  EXPECT_EQ(copied.err, "");
  EXPECT_NE(copied.out.find("66 of 66 slabs saved"), std::string::npos) << copied.out;
  fs::remove(folder_ / "out.t4d");

  write("broken.t4d", whole.substr(0, whole.size() / 2));
  for (const char* verb :
       {"info", "validate", "slice --time 1", "flipbook --frames 2 -o out.glb"}) {
    refuses(std::string(verb) + " broken.t4d",
            "t4d: try: t4d recover broken.t4d -o broken-recovered.t4d");
  }
  const Finished saved = run("recover broken.t4d -o saved.t4d --json");
  EXPECT_EQ(saved.exitCode, 3) << saved.err;
  EXPECT_NE(saved.err.find("t4d: lost: byte "), std::string::npos) << saved.err;
  const json said = saved.value();
  EXPECT_GT(said["slabs_saved"], 10);
  EXPECT_EQ(said["slabs_known"], nullptr);
  ASSERT_EQ(said["caps"].size(), 1U);
  EXPECT_EQ(said["caps"][0]["triangles"], 24);
  // The start cap, and steps of unit time.
  const double steps = said["slabs_saved"].get<double>() - 1;
  EXPECT_EQ(said["caps"][0]["time"], steps);
  EXPECT_NEAR(said["hypervolume"].get<double>(), steps * 8000, 1e-6);
  EXPECT_EQ(run("validate saved.t4d --deep").exitCode, 0);
  EXPECT_EQ(contents(folder_ / "broken.t4d"), whole.substr(0, whole.size() / 2));

  EXPECT_EQ(run("recover broken.t4d -o broken.t4d").exitCode, 2);
  EXPECT_EQ(run("recover broken.t4d").exitCode, 2);
  write("begin.t4d", whole.substr(0, 500));
  refuses("recover begin.t4d -o out.t4d", "no closed solid could be recovered");
  refuses("recover fx/cube.obj -o out.t4d", "is not a .t4d file");
}

TEST_F(Program, FormatsListsEachOnceWithWhatItKeeps) {
  std::set<std::string> ids;
  std::set<std::string> names;
  const json formats = run("formats --json").value()["formats"];
  for (const json& format : formats) {
    const auto name = format["name"].get<std::string>();
    const auto id = format["id"].get<std::string>();
    EXPECT_TRUE(format["reads"] || format["writes"]) << name;
    EXPECT_FALSE(format["keeps"].empty()) << name;
    EXPECT_FALSE(format["extensions"].empty()) << name;
    EXPECT_TRUE(id.empty() || ids.insert(id).second) << id;
    EXPECT_TRUE(names.insert(name).second) << name;
  }
}

TEST_F(Program, ConvertGivesTheSameSolidBackFromEachFormat) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  const json whole = run("validate cube.t4d --json").value();
  ASSERT_EQ(run("slice cube.t4d --time 20.3 -o before.ply").exitCode, 0);
  const json formats = run("formats --json").value()["formats"];
  int converted = 0;
  for (const json& format : formats) {
    if (format["kind"] != "4D mesh" || !format["reads"] || format["id"] == "t4d") continue;
    if (format["extensions"][0] == ".t4dm") continue;  // join writes it
    ++converted;
    const std::string there = "there" + format["extensions"][0].get<std::string>();
    const std::string to = " --to " + format["id"].get<std::string>();
    const Finished lossy = run("convert cube.t4d " + there + to + " --json");
    EXPECT_EQ(lossy.exitCode, 3) << there;
    EXPECT_GE(lossy.value()["losses"].size(), 1U);
    EXPECT_EQ(lossy.value()["out"]["format"], format["id"]);
    EXPECT_EQ(run("convert cube.t4d " + there + to + " --accept-loss").exitCode, 0);
    const Finished back = run("convert " + there + " back.t4d --json");
    ASSERT_EQ(back.exitCode, 0) << back.err;
    EXPECT_EQ(back.value()["in"]["format"], format["id"]);
    EXPECT_EQ(back.value()["vertices"], 4750);
    EXPECT_EQ(back.value()["tetrahedra"], 21552);
    const json again = run("validate back.t4d --json").value();
    for (const char* same : {"valid", "closed", "oriented", "components", "degenerate_cells"}) {
      EXPECT_EQ(again[same], whole[same]) << there << " " << same;
    }
    EXPECT_NEAR(again["hypervolume"].get<double>(), whole["hypervolume"].get<double>(), 1e-6);
    const json slice = run("slice back.t4d --time 20.3 --json").value();
    EXPECT_TRUE(slice["closed"]);
    EXPECT_NEAR(slice["volume"].get<double>(), 8000, 1e-6);
  }
  EXPECT_GE(converted, 7);
}

TEST_F(Program, ConvertMendsCutsAndRefuses) {
  const auto hypervolume = [&](const std::string& file) {
    return run("validate " + file + " --json").value()["hypervolume"].get<double>();
  };
  ASSERT_EQ(run("convert fx/24-cell.off whole.t4d").exitCode, 0);
  EXPECT_NEAR(hypervolume("whole.t4d"), 8, 1e-12);
  ASSERT_EQ(run("convert fx/600-cell.off cut.t4d --slabs 5").exitCode, 0);
  EXPECT_EQ(run("info cut.t4d --json").value()["slabs"], 5);
  const double golden = (1 + std::sqrt(5)) / 2;
  EXPECT_NEAR(hypervolume("cut.t4d"),
              150 * std::sqrt((4 + 6 * golden) / 16) / (6 * std::sqrt(2) * std::pow(golden, 3)),
              1e-12);
  // Without its last tetrahedron.
  ASSERT_EQ(run("convert fx/16-cell.off whole.off --to off-ijk").exitCode, 0);
  ASSERT_EQ(shell("sed -e 's/^8 16 0/8 15 0/' -e '$d' whole.off > open.off"), 0);
  refuses("convert open.off no.t4d",
          "is not closed: 4 of its triangles do not have two tetrahedra");
  refuses("convert open.off no.t4d", "--allow-open");
  const Finished open = run("convert open.off open.t4d --allow-open --json");
  EXPECT_EQ(open.exitCode, 0);
  EXPECT_FALSE(open.value()["closed"]);
  refuses("convert open.t4d no.off", "--allow-open");
  refuses("convert whole.off whole.off", "is the input itself", 2);
  refuses("convert whole.off out.xyz", "unsupported output extension", 2);
  refuses("convert whole.off out.t4d --from medit", "whole.off");
  refuses("convert fx/cube.obj out.t4d", "is not a 4D mesh in a known format");
  refuses("convert fx/labels.nrrd out.t4d", "t4d weave fx/labels.nrrd");
  refuses("convert whole.off out.t4d --weld -1", "--weld: '-1' is not a number from 0 on", 2);
  refuses("slice whole.off --time 0", "t4d convert whole.off whole");
}

TEST_F(Program, ConvertListsWhatAnotherFormatDoesNotKeepOfAFile) {
  ASSERT_EQ(run("sweep fx/cube.obj -m fx/rest.json --caps cone -o cube.t4d").exitCode, 0);
  const auto lossOf = [&](const std::string& file) {
    const auto done = run("convert " + file + " out.vtu");
    EXPECT_EQ(done.exitCode, 3);
    return done.err;
  };
  EXPECT_THAT(lossOf("cube.t4d"), testing::HasSubstr("upward axis, how the mesh was made\n"));
  ASSERT_EQ(run("transform cube.t4d --space RAS -o patient.t4d").exitCode, 0);
  EXPECT_THAT(lossOf("patient.t4d"),
              testing::HasSubstr("the anatomical space not kept by vtu: RAS\n"));
}

TEST_F(Program, ConvertNotesChoicesThatMayBeMistakes) {
  const auto notes = [&](const std::string& arguments) { return run("convert " + arguments).err; };
  EXPECT_THAT(
      notes("fx/16-cell.off a.t4d --slabs 9"),
      testing::HasSubstr("cut into 2 slabs, not 9: its vertices have only 3 different times"));
  EXPECT_THAT(notes("fx/600-cell.off a.vtu --slabs 2"), testing::HasSubstr("has no slabs"));
  EXPECT_THAT(notes("fx/16-cell.off a.vtu --to gmsh"),
              testing::HasSubstr("a.vtu: written as Gmsh MSH 4.1, the time as node data, as --to "
                                 "says; its extension is that of VTK"));
  EXPECT_THAT(notes("fx/16-cell.off b.off --to off-ijk"), testing::Not(testing::HasSubstr("--to")));
}

TEST_F(Program, WeaveSaysWhatItDoesNotRead) {
  refuses("weave fx/labels.nrrd -o out.t4d", "--label N");
  refuses("weave fx/labels.nrrd --label 2 --start-time 1e300 -o out.t4d",
          "frame 0 is at time 1e+300; the largest possible is 1e+70");
  write("grid.xyz", "no grid");
  refuses("weave grid.xyz -o out.t4d", "not a volume by its extension; expected .vdb, .nrrd");
  ASSERT_EQ(shell("mkdir volumes && cp fx/labels.nrrd volumes"), 0);
  refuses("weave volumes -o out.t4d",
          "is a folder of 1 volume, and none is a .vdb file; name the "
          "volumes, as volumes/*.nrrd");
  std::string minusOnes = "raw float32 2 2 2 2\n";
  for (int i = 0; i < 16; ++i) minusOnes += std::string("\0\0\x80\xBF", 4);
  write("minus.raw", minusOnes);
  EXPECT_THAT(run("weave minus.raw --frame-time 1 -o minus.t4d").err,
              testing::HasSubstr("taken as distances"));
}

TEST_F(Program, WeavesARegion) {
  ASSERT_EQ(run("weave fx/labels.nrrd --label 2 -o whole.t4d").exitCode, 0);
  const std::string part = "weave fx/labels.nrrd --label 2 -o part.t4d --region ";
  const Finished cut = run(part + ":,8:,:,1:4 --json");
  ASSERT_EQ(cut.exitCode, 0) << cut.err;
  EXPECT_EQ(cut.value()["frames"], 3);
  EXPECT_THAT(cut.err, testing::HasSubstr("is closed there: at y = 8"));
  const json info = run("info part.t4d --json").value();
  EXPECT_EQ(info["details"]["parameters"]["region"], ":,8:,:,1:4");
  refuses(part + ":,:,:,1:99", "labels.nrrd: --region has 1:99 along t, where there are");
  for (const std::string wrong : {":,:", "4:4,:,:", "a:,:,:"}) {
    EXPECT_EQ(run(part + wrong).exitCode, 2) << wrong;
  }
  EXPECT_EQ(run("weave fx/bending_*.obj --voxel-size 1 --region :,:,: -o out.t4d").exitCode, 2);
}

TEST_F(Program, JoinsTheHalvesThatTwoProcessesSweep) {
  const std::string sweep = "sweep fx/torus.obj --motion fx/several-segments.json --caps cone ";
  ASSERT_EQ(run(sweep + "-o whole.t4d").exitCode, 0);
  const auto part = [&](const std::string& which, const std::string& output) {
    return "$t4d " + sweep + "--part " + which + " -o " + output + " > /dev/null 2>&1";
  };
  ASSERT_EQ(shell("{ " + part("1/2", "a.t4d") + " & " + part("2/2", "b.t4d") + " && wait $!; }"),
            0);
  EXPECT_EQ(run("validate a.t4d").exitCode, 4);
  const Finished joined = run("join a.t4d b.t4d -o joined.t4d --json");
  ASSERT_EQ(joined.exitCode, 0) << joined.err;
  EXPECT_EQ(joined.value()["bytes"], fs::file_size(folder_ / "joined.t4d"));
  const json whole = run("validate whole.t4d --json").value();
  EXPECT_EQ(run("validate joined.t4d --json").value(), whole);
  for (const char* time : {"0.1", "1", "2.3"}) {
    ASSERT_EQ(run(std::string("slice whole.t4d -o whole.ply --time ") + time).exitCode, 0);
    ASSERT_EQ(run(std::string("slice joined.t4d -o joined.ply --time ") + time).exitCode, 0);
    EXPECT_EQ(contents(folder_ / "whole.ply"), contents(folder_ / "joined.ply"));
  }
  // A pipe, with or without a name, gives the results of the file.
  EXPECT_EQ(run("validate - --json < joined.t4d").value(), whole);
  ASSERT_EQ(shell("mkfifo pipe && (cat joined.t4d > pipe &) && $t4d validate pipe > /dev/null"), 0);
  json info = run("info joined.t4d --slabs --json").value();
  EXPECT_EQ(run("info - --slabs --json < joined.t4d").value(), info);

  // A manifest joins without copying: it is a file in parts, which every verb reads.
  const Finished named = run("join a.t4d b.t4d --manifest -o parts.t4dm --json");
  ASSERT_EQ(named.exitCode, 0) << named.err;
  EXPECT_EQ(named.value()["bytes"], fs::file_size(folder_ / "parts.t4dm"));
  EXPECT_EQ(named.value()["vertices"], joined.value()["vertices"]);
  EXPECT_EQ(run("validate parts.t4dm --json").value(), whole);
  for (const std::string verb :
       {"slice --time 1.3 -o made.ply", "slice --x 0 -o made.ply", "frames -n 1 -o made.%d.stl",
        "transform --scale 2 -o made.t4d", "compress -o made.t4d",
        "filter --from 0.4 --to 1.9 -o made.t4d", "convert made.off"}) {
    const std::size_t space = verb.find(' ');
    const auto made = [&](const std::string& input) {
      const Finished done =
          run(verb.substr(0, space) + " " + input + verb.substr(space) + " --json");
      EXPECT_TRUE(done.exitCode == 0 || done.exitCode == 3) << verb << ": " << done.err;
      const std::string name = verb.substr(verb.rfind("made."));
      return contents(folder_ / (name == "made.%d.stl" ? "made.0.stl" : name));
    };
    EXPECT_EQ(made("parts.t4dm"), made("joined.t4d")) << verb;
  }
  for (const std::string verb : {"measure", "quality", "info --slabs", "du"}) {
    json one = run(verb + " joined.t4d --json").value();
    json parts = run(verb + " parts.t4dm --json").value();
    // The parts have a HEAD, an index and so on each.
    for (json* value : {&one, &parts}) {
      for (const char* name : {"bytes", "chunks", "other_bytes", "bytes_per_tetrahedron", "file"}) {
        value->erase(name);
      }
    }
    EXPECT_EQ(parts, one) << verb;
  }
  EXPECT_EQ(run("diff parts.t4dm joined.t4d --json").value()["level"], "mesh");
  ASSERT_EQ(run("join parts.t4dm -o again.t4d").exitCode, 0);
  EXPECT_EQ(contents(folder_ / "again.t4d"), contents(folder_ / "joined.t4d"));
  refuses("join a.t4d b.t4d -o no.t4dm", "add --manifest", 2);
  refuses("join a.t4d b.t4d --manifest -o no.t4d", "ends in .t4dm", 2);
  refuses("join a.t4d --manifest -o fx/no.t4dm", "is not in the folder of", 2);
  refuses(sweep + "-o no.t4dm", "has the name of another format", 2);
  refuses("recover parts.t4dm -o no.t4d", "is a file in parts");
  ASSERT_EQ(run("view parts.t4dm -o parts.html --json").exitCode, 0);
  fs::rename(folder_ / "b.t4d", folder_ / "away.t4d");
  refuses("slice parts.t4dm --time 1 -o no.ply", "b.t4d: cannot open");
  fs::copy(folder_ / "a.t4d", folder_ / "b.t4d");
  refuses("slice parts.t4dm --time 1 -o no.ply", "b.t4d: is not the part that parts.t4dm");
  fs::rename(folder_ / "away.t4d", folder_ / "b.t4d");

  refuses("join b.t4d a.t4d -o no.t4d", "cannot be joined after b.t4d");
  refuses("join a.t4d a.t4d -o no.t4d", "the body 'torus' begins at time");
  refuses("join a.t4d fx/torus.obj -o no.t4d", "torus.obj: byte 0: is not a .t4d file");
  refuses("join a.t4d b.t4d -o a.t4d", "is the input itself", 2);
  refuses("join -o no.t4d", "name the files to join", 2);

  // Two processes join into one file.
  ASSERT_EQ(run("join a.t4d b.t4d --plan -o shared.t4d").exitCode, 0);
  EXPECT_EQ(run("join -o shared.t4d --most-parts").value()["parts"], 2);
  refuses("join a.t4d b.t4d --plan -o shared.t4d", "is planned already", 1);
  refuses("join -o shared.t4d --part 1/3", "there are 2 files to join, too few", 2);
  refuses("join -o shared.t4d --finish", "2 of 2 files are not copied yet: a.t4d, b.t4d");
  refuses("join a.t4d -o shared.t4d --finish", "name none", 2);
  refuses("join a.t4d --plan --manifest -o no.t4dm", "exclude each other", 2);
  refuses("join -o no.t4d --finish", "no join into this file is planned");
  refuses("join -o - --finish", "name a file", 2);
  const auto copy = [](const std::string& which) {
    return "$t4d join -q -o shared.t4d --part " + which;
  };
  ASSERT_EQ(shell("{ " + copy("1/2") + " & " + copy("2/2") + " && wait $!; }"), 0);
  EXPECT_FALSE(fs::exists(folder_ / "shared.t4d"));
  EXPECT_EQ(run("join -o shared.t4d --finish --json").value(), joined.value());
  EXPECT_EQ(contents(folder_ / "shared.t4d"), contents(folder_ / "joined.t4d"));
  EXPECT_FALSE(fs::exists(folder_ / "shared.t4d.joining"));
  refuses(sweep + "--part 3/2 -o no.t4d", "'3/2' is not K/N", 2);
  refuses(sweep + "--part 1/2 --center -o no.t4d", "--part and --center", 2);
  refuses(sweep + "--steps 1 --part 1/1000 -o no.t4d", "too few for 1000 parts");
  refuses("slice - --time 1 -o no.ply", "standard input: slabs are read at their offsets");
}

TEST_F(Program, SuggestsRecoveryOnlyWhereItSavesSomething) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  const std::string whole = contents(folder_ / "cube.t4d");
  const auto hint = [&](const std::string& command) {
    const std::string err = run(command).err;
    const std::size_t at = err.find("t4d: try: ");
    return at == std::string::npos ? "" : err.substr(at + 10, err.find('\n', at) - at - 10);
  };
  std::string connectivity = whole;  // damaged where all slabs but the caps share it
  connectivity[whole.find("CONN", whole.find("CONN") + 1) + 40] ^= 1;
  const std::size_t afterHead = whole.find("CONN") + 8;
  for (const std::string& lost : {whole.substr(0, 8), whole.substr(0, 23), connectivity,
                                  whole.substr(0, afterHead), std::string(9000, '\0')}) {
    write("lost.t4d", lost);
    for (const char* command :
         {"info lost.t4d", "validate lost.t4d", "recover lost.t4d -o out.t4d"}) {
      EXPECT_EQ(hint(command), "") << command << ", " << lost.size() << " bytes";
    }
  }

  std::string zeros = whole;
  zeros.replace(0, 512, 512, '\0');
  write("zeros.t4d", zeros);
  EXPECT_EQ(hint("info zeros.t4d"), "t4d recover zeros.t4d -o zeros-recovered.t4d");
  EXPECT_EQ(run("recover zeros.t4d -o zeros-recovered.t4d").exitCode, 3);
  EXPECT_EQ(hint("info zeros.t4d"), "t4d recover zeros.t4d -o zeros-recovered-2.t4d");

  write("-x.t4d", zeros);
  EXPECT_EQ(hint("info -- -x.t4d"), "t4d recover ./-x.t4d -o ./-x-recovered.t4d");
  EXPECT_EQ(run("recover ./-x.t4d -o ./-x-recovered.t4d").exitCode, 3);
  fs::create_directory(folder_ / "a b");
  write("a b/x.t4d", zeros);
  EXPECT_EQ(hint("info 'a b/x.t4d'"), "t4d recover 'a b/x.t4d' -o 'a b/x-recovered.t4d'");
}

TEST_F(Program, InfoTellsOfARecoveredFile) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  std::string bytes = contents(folder_ / "cube.t4d");
  EXPECT_EQ(run("info cube.t4d").out.find("recovered"), std::string::npos);
  bytes[bytes.find("SLAB", bytes.size() / 2) + 40] ^= 1;
  write("broken.t4d", bytes);
  EXPECT_EQ(run("recover broken.t4d -o saved.t4d").exitCode, 3);
  const Finished info = run("info saved.t4d");
  EXPECT_NE(info.out.find("recovered from broken.t4d: 65 of 66 slabs; nothing between time "),
            std::string::npos)
      << info.out;
}

TEST_F(Program, WrongUsageIsExit2) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  for (const char* arguments :
       {"", "swep", "sweep", "sweep fx/cube.obj -o out.t4d", "slice cube.t4d",
        "slice cube.t4d --time 1 --x 2", "slice cube.t4d --time abc",
        "slice cube.t4d --hyperplane 1,2,3", "rasterize cube.t4d -o a",
        "flipbook cube.t4d -n 2 --times 1:2:3 -o a.glb", "flipbook cube.t4d --frames 0 -o a.glb",
        "flipbook cube.t4d --times 1:2 -o a.glb",
        "sweep fx/cube.obj -m fx/rest.json -o out.t4d --steps 2 --rv-min 0.9",
        "sweep fx/cube.obj -m fx/rest.json -o out.t4d --prism 5", "info"}) {
    EXPECT_EQ(run(arguments).exitCode, 2) << arguments;
  }
}

TEST_F(Program, NamesWhatItDoesNotUnderstand) {
  misused("slice cube.t4d --tiem 1", "not understood: --tiem");
  misused("--tiem", "not understood: --tiem");
  const std::string verbs = "the verbs of t4d are sweep, slice, ";
  misused("slcie fx/cube.obj", "unknown verb 'slcie' (did you mean slice?); " + verbs);
  misused("extrude fx/cube.obj", "unknown verb 'extrude'; " + verbs);
  misused("", "a verb is missing; " + verbs);
  misused("conform raeder",
          "unknown verb 'raeder' (did you mean reader?); the verbs of t4d conform are ");
  misused("conform", "a verb is missing; the verbs of t4d conform are ");
}

TEST_F(Program, SaysWhatToDoWithAFileOfAnotherKind) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  const std::string sweep =
      "t4d: it is a triangle mesh; sweep it first: t4d sweep fx/cube.obj --motion MOTION.json -o "
      "fx/cube.t4d\n";
  for (const char* verb : {"info", "validate", "slice --time 1", "flipbook --frames 2 -o out.glb",
                           "recover -o out.t4d", "rasterize --voxel-size 1 --frames 2 -o out"}) {
    refuses(std::string(verb) + " fx/cube.obj", sweep);
  }
  for (const char* verb : {"sweep -m fx/rest.json -o out.t4d",
                           "voxelize -m fx/rest.json --voxel-size 1 --frames 2 -o out"}) {
    refuses(std::string(verb) + " cube.t4d",
            "t4d: it is a 4D mesh; slice it first: t4d slice cube.t4d --time 0 -o cube-slice.ply");
  }
  // Nor is a damaged .t4d one that could be sliced, nor what is written and never read a 4D mesh.
  std::ifstream swept(folder_ / "cube.t4d", std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(swept), {}};
  for (const std::size_t at : {bytes.size() / 3, bytes.size() / 2}) {
    bytes[at] = static_cast<char>(bytes[at] ^ 16);
    write("flipped.t4d", bytes);
    EXPECT_THAT(run("validate flipped.t4d").err, testing::Not(testing::HasSubstr("slice it")));
    bytes[at] = static_cast<char>(bytes[at] ^ 16);
  }
  ASSERT_EQ(run("slice cube.t4d --time 0 -o slice.vtp").exitCode, 0);
  refuses("info slice.vtp", "it is a triangle mesh; sweep it first");
  refuses("convert slice.vtp out.t4d", "is not a 4D mesh in a known format");
  // What begins as a .t4d is one, whatever its name.
  write("cube.dat", bytes);
  EXPECT_EQ(run("convert cube.dat out.off --accept-loss").exitCode, 0);
  // A damaged mesh is not mistaken for another format.
  write("broken.glb", "no glTF");
  EXPECT_THAT(run("sweep broken.glb -m fx/rest.json -o out.t4d").err,
              testing::Not(testing::HasSubstr("first:")));
}

TEST_F(Program, HelpHasAnExampleForEachVerb) {
  for (const std::string verb :
       {"sweep", "weave", "voxelize", "rasterize", "slice", "flipbook", "frames", "info",
        "validate", "recover", "compare", "conform", "conform backends", "conform reader",
        "conform copy", "conform list", "version"}) {
    const Finished help = run(verb + " --help");
    EXPECT_EQ(help.exitCode, 0);
    EXPECT_THAT(help.out, testing::ContainsRegex("Examples?:\n  t4d " + verb));
  }
}

TEST_F(Program, MessagesThatCannotBePrintedChangeNothing) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  for (const std::string lost : {" > out.txt 2>&-", " > out.txt 2> /dev/full"}) {
    EXPECT_EQ(shell("$t4d info nosuch" + lost), 4) << lost;
    EXPECT_EQ(shell("$t4d swep" + lost), 2) << lost;
    EXPECT_EQ(shell("$t4d sweep fx/cube.obj -o a.t4d -m fx/rest.json --voxel-size 1" + lost), 2);
    EXPECT_EQ(shell("$t4d slice cube.t4d --time 1 --attributes -o a.stl" + lost), 3) << lost;
    EXPECT_EQ(shell("$t4d conform list --only nothing" + lost), 2) << lost;
  }
  // No message is written into an output file.
  ASSERT_EQ(run("slice cube.t4d --time 1 --attributes -o a.stl").exitCode, 3);
  const std::string whole = contents(folder_ / "a.stl");
  EXPECT_EQ(shell("$t4d slice cube.t4d --time 1 --attributes -o b.stl >&- 2>&- <&-"), 1);
  EXPECT_EQ(contents(folder_ / "b.stl"), whole);
}

TEST_F(Program, ResultsThatCannotBePrintedAreExit1) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  for (const std::string arguments :
       {"info cube.t4d", "info cube.t4d --json", "validate cube.t4d", "slice cube.t4d --time 1",
        "slice cube.t4d --time 1 --json", "compare cube.t4d cube.t4d --slices 1",
        "flipbook cube.t4d --frames 2 -o a.glb", "recover cube.t4d -o b.t4d --json",
        "sweep fx/cube.obj -m fx/rest.json -o c.t4d --json", "version", "version --json", "--help",
        "--version", "sweep --help", "conform backends --list", "conform list"}) {
    for (const std::string lost : {" > /dev/full", " >&-"}) {
      EXPECT_EQ(shell("$t4d " + arguments + lost + " 2> err.txt"), 1) << arguments << lost;
      EXPECT_THAT(contents(folder_ / "err.txt"),
                  testing::HasSubstr("t4d: cannot write to standard output"))
          << arguments << lost;
    }
  }
  // A reader of the output that stops early is not an error.
  EXPECT_EQ(shell("$t4d conform list 2> err.txt | head -1 > out.txt"), 0);
  EXPECT_EQ(contents(folder_ / "err.txt"), "");
}

TEST_F(Program, SaysThatASliceIsEmpty) {
  ASSERT_EQ(run("sweep fx/cube.obj -m fx/rest.json -o cube.t4d").exitCode, 0);
  const Finished empty = run("slice cube.t4d --x 1000");
  EXPECT_EQ(empty.exitCode, 0);
  EXPECT_NE(empty.err.find("note: the slice is empty"), std::string::npos) << empty.err;
  EXPECT_EQ(run("slice cube.t4d --x 0.1").err, "");
}

TEST_F(Program, RefusesBadMeshes) {
  const auto sweep = [](const std::string& mesh) {
    return "sweep " + mesh + " -m fx/paper-screw.json -o out.t4d";
  };
  const std::string cube = contents(folder_ / "fx" / "cube.obj");
  const auto lastFace = cube.rfind("\nf ");
  write("open.obj", cube.substr(0, lastFace + 1));
  refuses(sweep("open.obj"), "open.obj: the mesh is open: 3 boundary edges");
  std::string turned = cube;
  const auto face = turned.substr(lastFace + 3);
  write(
      "turned.obj", cube.substr(0, lastFace + 1) + "f " + [&] {
        std::istringstream in(face);
        std::string a, b, c;
        in >> a >> b >> c;
        return b + " " + a + " " + c + "\n";
      }());
  refuses(sweep("turned.obj"), "inconsistent orientation");
  write("edge.obj", cube + "v 9 9 9\nf 1 2 9\nf 2 1 9\n");
  refuses(sweep("edge.obj"), "non-manifold edge");
  write("nan.obj", "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n");
  refuses(sweep("nan.obj"), "nan.obj:3");
  write("inf.obj", "v 0 0 0\nv 1 0 inf\nv 0 1 0\nf 1 2 3\n");
  refuses(sweep("inf.obj"), "inf.obj:2");
  write("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n");
  refuses(sweep("index.obj"), "index.obj:4");
  write("empty.obj", "# nothing\n");
  refuses(sweep("empty.obj"), "no triangles");
  refuses(sweep("missing.obj"), "missing.obj");
  refuses(sweep("fx"), "fx");
}

TEST_F(Program, NoticesAnInsideOutMesh) {
  std::string text;
  std::istringstream in(contents(folder_ / "fx" / "cube.obj"));
  for (std::string line; std::getline(in, line);) {
    if (line.rfind("f ", 0) == 0) {
      std::istringstream words(line.substr(2));
      std::string a, b, c;
      words >> a >> b >> c;
      line = "f " + b + " " + a + " " + c;
    }
    text += line + "\n";
  }
  write("inside-out.obj", text);
  const Finished done = run("sweep inside-out.obj -m fx/paper-screw.json -o turned.t4d");
  EXPECT_EQ(done.exitCode, 0);
  EXPECT_NE(done.err.find("was flipped"), std::string::npos);
  EXPECT_GT(run("validate turned.t4d --json").value()["hypervolume"], 0);
}

TEST_F(Program, RefusesBadMotionsAndRules) {
  const auto motion = [&](const std::string& text, const std::string& expected) {
    write("m.json", text);
    refuses("sweep fx/cube.obj -m m.json -o out.t4d", expected);
  };
  motion(R"({"segments": [{"duration": 0}]})", "backward through time");
  motion(R"({"segments": [{"duration": -1}]})", "m.json: segment 0");
  motion(R"({"segments": [{"duration": 1, "angle_degrees": 5, "axis_direction": [0, 0, 0]}]})",
         "length 0");
  motion(R"({"segments": [{"duration": 1, "axis": [0, 0, 1]}]})", "unknown key 'axis'");
  motion("{", "not JSON");
  const std::string base = "sweep fx/cube.obj -m fx/paper-screw.json -o out.t4d ";
  misused(base + "--rv-min 1", "--rv-min: '1' is not a number from 0 to less than 1");
  misused(base + "--rv-min -0.5", "--rv-min: '-0.5'");
  misused(base + "--rv-min nan", "--rv-min: 'nan'");
  misused(base + "--steps 0", "--steps: '0' is not a whole number from 1 to 100000000");
  misused(base + "--steps -1", "--steps: '-1'");
  misused(base + "--steps ''", "--steps: ''");
  misused(base + "--max-deviation 0", "--max-deviation: '0' is not a number above 0");
  misused(base + "--tolerance 0", "--tolerance: '0' is not a number above 0");
  misused(base + "--threads 0", "--threads: '0' is not a whole number from 1 to 1024");
  refuses("sweep fx/cube.obj -m missing.json -o out.t4d", "missing.json");
}

TEST_F(Program, RefusesTimesOutsideAndUnknownOutputs) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  refuses("slice cube.t4d --time 65 -o out.glb",
          "cube.t4d: time 65 is outside the mesh, which lasts from 0 to 64");
  refuses("slice cube.t4d --time -1 -o out.glb", "lasts from 0 to 64");
  EXPECT_EQ(run("slice cube.t4d --hyperplane 0,0,0,0,1").exitCode, 2);
  EXPECT_EQ(run("slice cube.t4d --hyperplane 0 0 1 -2 0.5 --json").out,
            run("slice cube.t4d --hyperplane 0,0,1,-2,0.5 --json").out);
  EXPECT_EQ(run("slice cube.t4d --hyperplane 1e-170,0,0,0,0").exitCode, 0);
  misused("slice cube.t4d --time nan -o out.glb", "--time: 'nan' is not a number");
  misused("slice cube.t4d --hyperplane 0,0,0,0,1 -o out.glb", "--hyperplane: ");
  misused("slice cube.t4d --time 1 -o out.xyz",
          ".stl, .obj, .ply, .off, .vtp, .gltf, .glb, .usda or .usdz");
  misused("flipbook cube.t4d --frames 2 -o out.stl", "--output: ");
  misused("recover cube.t4d -o out.stl", "has the name of another format; a .t4d is written");
  misused("flipbook cube.t4d --frames 2.5 -o out.glb",
          "--frames: '2.5' is not a whole number from 1 to 100000");
  misused("flipbook cube.t4d --frames 2 --fps 0 -o out.glb", "--fps: '0' is not a number above 0");
  refuses("slice cube.t4d --time 1 --body lid -o out.glb", "has no body 'lid'; it has paper-cube");
  refuses("flipbook cube.t4d --times 60:70:3 -o out.glb", "time 65 is outside");
  refuses("slice missing.t4d --time 1 -o out.glb", "missing.t4d: cannot open: No such file");
  refuses("info fx/cube.obj", "is not a .t4d file");
  refuses("info fx", "fx: is a folder");
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
  cannot("sweep fx/cube.obj -m fx/rest.json -o fx", "is a folder");
  cannot("compare cube.t4d cube.t4d --slices 1 --html nowhere/page", "nowhere/page");
  misused("sweep fx/cube.obj -m fx/rest.json -o ''", "--output: the name is empty");
  misused("slice cube.t4d --time 1 -o ''", "--output: the name is empty");
}

TEST_F(Program, NoInputIsWrittenOver) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  ASSERT_EQ(run("voxelize fx/cube.obj -m fx/rest.json --voxel-size 4 --frames 2 -o two").exitCode,
            0);
  fs::create_symlink(folder_ / "cube.t4d", folder_ / "link.glb");
  fs::create_hard_link(folder_ / "fx" / "cube.obj", folder_ / "hard.t4d");
  fs::create_symlink(folder_ / "fx" / "rest.json", folder_ / "motion.t4d");
  fs::create_symlink(folder_ / "two" / "frame_0001.vdb", folder_ / "frame.t4d");
  const auto keeps = [&](const std::string& arguments, const std::string& file) {
    const std::string before = contents(folder_ / file);
    misused(arguments, "name another file");
    EXPECT_EQ(contents(folder_ / file), before);
  };
  for (const char* output : {"hard.t4d", "./fx/../hard.t4d"}) {
    keeps(std::string("sweep fx/cube.obj -m fx/rest.json -o ") + output, "fx/cube.obj");
  }
  keeps("sweep fx/cube.obj -m fx/rest.json -o motion.t4d", "fx/rest.json");
  keeps("slice cube.t4d --time 1 -o link.glb", "cube.t4d");
  keeps("flipbook cube.t4d --frames 2 -o link.glb", "cube.t4d");
  keeps("compare cube.t4d cube.t4d --html cube.t4d", "cube.t4d");
  keeps("weave two -o frame.t4d", "two/frame_0001.vdb");
  keeps("weave two/frame_0000.vdb two/frame_0001.vdb -o frame.t4d", "two/frame_0001.vdb");
}

/// fx/NAME.obj with every vertex times `scale` plus `offset`, as NAME-placed.obj.
void placeFixture(const fs::path& folder, const std::string& name, double scale, double offset) {
  std::ifstream in(folder / "fx" / (name + ".obj"));
  std::ofstream out(folder / (name + "-placed.obj"));
  out.precision(17);
  for (std::string line; std::getline(in, line);) {
    double x = 0;
    double y = 0;
    double z = 0;
    if (std::sscanf(line.c_str(), "v %lf %lf %lf", &x, &y, &z) == 3) {
      out << "v " << x * scale + offset << " " << y * scale + offset << " " << z * scale + offset
          << "\n";
    } else {
      out << line << "\n";
    }
  }
}

TEST_F(Program, TheBufferOfAGltfIsNoOutput) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  ASSERT_EQ(run("slice cube.t4d --time 0 -o at.gltf").exitCode, 0);
  json gltf = json::parse(contents(folder_ / "at.gltf"));
  const std::string uri = gltf["buffers"][0]["uri"];
  write("buffer.b64", uri.substr(uri.find(',') + 1));
  ASSERT_EQ(shell("base64 -d buffer.b64 > b.bin"), 0);
  gltf["buffers"][0]["uri"] = "b.bin";
  write("ext.gltf", gltf.dump());
  const std::string before = contents(folder_ / "b.bin");
  misused("sweep ext.gltf -m fx/rest.json -o b.bin", "the output b.bin is the input");
  misused("compare ext.gltf -m fx/rest.json --voxel-size 2 --html b.bin", "b.bin is the input");
  EXPECT_EQ(contents(folder_ / "b.bin"), before);
  EXPECT_EQ(run("sweep ext.gltf -m fx/rest.json -o ext.t4d").exitCode, 0);
}

TEST_F(Program, ShapesThatFloat32CannotHoldAreALossAndCenteringTheWayOut) {
  placeFixture(folder_, "cube", 0.01, 5e6);
  ASSERT_EQ(run("sweep cube-placed.obj -m fx/rest.json -o map.t4d").exitCode, 0);
  for (const char* output : {"at.stl", "at.glb"}) {
    const Finished lost = run(std::string("slice map.t4d --time 0.5 -o ") + output);
    EXPECT_EQ(lost.exitCode, 3);
    EXPECT_NE(lost.err.find("become flat or turn over in float32"), std::string::npos) << lost.err;
    EXPECT_EQ(run(std::string("slice map.t4d --time 0.5 --center -o ") + output).exitCode, 0);
  }
  EXPECT_EQ(run("slice map.t4d --time 0.5 -o at.ply").exitCode, 0);
  EXPECT_EQ(contents(folder_ / "at.stl").substr(0, 30), "origin 5000000 5000000 5000000");
  EXPECT_EQ(run("flipbook map.t4d -n 2 -o moving.gltf").exitCode, 3);
  EXPECT_EQ(run("flipbook map.t4d -n 2 --center -o moving.gltf").exitCode, 0);
  const json gltf = json::parse(contents(folder_ / "moving.gltf"));
  EXPECT_EQ(gltf["nodes"][0]["translation"], json::array({5e6, 5e6, 5e6}));

  const std::string sweep = "sweep cube-placed.obj -m fx/rest.json --precision float32 ";
  EXPECT_EQ(run(sweep + "-o flat.t4d").exitCode, 3);
  ASSERT_EQ(run(sweep + "--center -o centered.t4d").exitCode, 0);
  EXPECT_NEAR(run("validate centered.t4d --json").value()["hypervolume"].get<double>(), 0.08, 1e-8);
  EXPECT_EQ(run("info centered.t4d --json").value()["details"]["origin"],
            json::array({5e6, 5e6, 5e6}));
  EXPECT_NE(run("info centered.t4d").out.find("origin is at (5000000, 5000000, 5000000)"),
            std::string::npos);
  ASSERT_EQ(run("slice centered.t4d --time 0.5 -o centered.gltf").exitCode, 0);
  EXPECT_EQ(json::parse(contents(folder_ / "centered.gltf"))["nodes"][0]["translation"],
            json::array({5e6, 5e6, 5e6}));
}

TEST_F(Program, EndsThatFloat32FlattensAreALoss) {
  write("far.json", R"({"segments": [{"duration": 1, "translation": [2e10, 0, 0]}]})");
  EXPECT_EQ(run("sweep fx/cube.obj -m far.json --precision float32 -o far.t4d").exitCode, 3);
  EXPECT_EQ(run("sweep fx/cube.obj -m far.json -o far.t4d").exitCode, 0);
}

TEST_F(Program, NumbersBeyondWhatHoldsAreRefusedByTheFileThatHasThem) {
  const auto moves = [&](const std::string& members) {
    write("motion.json", R"({"segments": [{"duration": 4, )" + members + "}]}");
  };
  moves(R"("translation": [1e300, 0, 0])");
  refuses("sweep fx/cube.obj -m motion.json -o out.t4d", "motion.json: segment 0");
  moves(R"("translation": [1e20, 0, 0])");
  refuses("sweep fx/cube.obj -m motion.json -o out.t4d", "motion.json: segment 0 moves the solid");
  moves(R"("axis_direction": [0, 0, 1], "angle_degrees": 1e14)");
  refuses("sweep fx/cube.obj -m motion.json -o out.t4d", "motion.json: the motion needs");
  write("late.json", R"({"start_time": 1e16, "segments": [{"duration": 4, "angle_degrees": 90,
                         "axis_direction": [0, 0, 1]}]})");
  refuses("sweep fx/cube.obj -m late.json -o out.t4d", "late.json: segment 0 lasts 4");
  refuses("sweep fx/cube.obj -m late.json --backend voxel4d --voxel-size 4 -o out.t4d",
          "late.json: ");
  placeFixture(folder_, "cube", 1e80, 0);
  refuses("sweep cube-placed.obj -m fx/rest.json -o out.t4d",
          "cube-placed.obj: has coordinates of");
  placeFixture(folder_, "cube", 1e40, 0);
  refuses("sweep cube-placed.obj -m fx/rest.json --backend voxel4d --voxel-size 4e40 -o out.t4d",
          "voxels of 4e+40 are requested");
  write("twice.json", R"({"segments": [{"duration": 4, "duration": 5}]})");
  refuses("sweep fx/cube.obj -m twice.json -o out.t4d", "the key 'duration' twice");
}

TEST_F(Program, SmallVoxelsWorkByFilesAndWithout) {
  placeFixture(folder_, "cube", 1e-6, 0);
  ASSERT_EQ(run("sweep cube-placed.obj -m fx/rest.json --backend voxel4d --voxel-size 2e-6 "
                "--frames 2 -o a.t4d")
                .exitCode,
            0);
  const std::string voxelize =
      "voxelize cube-placed.obj -m fx/rest.json --voxel-size 2e-6 --frames 2 -o ";
  ASSERT_EQ(run(voxelize + "frames").exitCode, 0);
  ASSERT_EQ(run("weave frames -o b.t4d").exitCode, 0);
  const json a = run("validate a.t4d --json").value();
  const json b = run("validate b.t4d --json").value();
  EXPECT_EQ(a["valid"], true);
  EXPECT_EQ(a["hypervolume"], b["hypervolume"]);
  EXPECT_NEAR(a["hypervolume"].get<double>() / (8e-15 * 10), 1, 0.2);
  // The same input makes the same bytes.
  ASSERT_EQ(run(voxelize + "again").exitCode, 0);
  for (const char* name : {"frame_0000.vdb", "frame_0001.vdb"}) {
    EXPECT_EQ(contents(folder_ / "frames" / name), contents(folder_ / "again" / name));
  }
}

TEST_F(Program, EmptyResultsHaveANote) {
  write("nowhere.obj",
        "v 0.3 0.3 0.3\nv 0.6 0.3 0.3\nv 0.3 0.6 0.3\nv 0.3 0.3 0.6\n"
        "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
  const Finished done =
      run("voxelize nowhere.obj -m fx/rest.json --voxel-size 1 --frames 2 -o frames");
  EXPECT_EQ(done.exitCode, 0);
  EXPECT_NE(done.err.find("voxels of 1 are larger than the solid"), std::string::npos) << done.err;
  EXPECT_NE(done.err.find("2 of 2 frames have no point inside"), std::string::npos) << done.err;
}

TEST_F(Program, OutputsThatCannotBeAreRefusedAtOnce) {
  const std::string sweep = "sweep fx/cube.obj -m fx/rest.json -o ";
  cannot(sweep + "/dev/stdout", "is the standard output");
  cannot(sweep + "missing/out.t4d", "there is no folder missing");
  fs::create_symlink("b", folder_ / "a");
  fs::create_symlink("a", folder_ / "b");
  cannot(sweep + "a", "Too many levels of symbolic links");
  fs::create_symlink("real.t4d", folder_ / "link.t4d");
  EXPECT_EQ(run(sweep + "link.t4d").exitCode, 0);
  EXPECT_TRUE(fs::is_symlink(folder_ / "link.t4d"));
  EXPECT_EQ(run("info real.t4d").exitCode, 0);
  // A pipe that is not the standard output.
  EXPECT_EQ(shell("mkfifo pipe && (cat pipe > piped.t4d & $t4d " + sweep + "pipe > log; wait)"), 0);
  EXPECT_EQ(run("validate piped.t4d").exitCode, 0);
}

TEST_F(Program, NamesDoNotCommandTheTerminal) {
  const Finished refused =
      run("sweep fx/cube.obj -m fx/rest.json --body \"$(printf 'a\\033[31mb')\" -o a.t4d");
  EXPECT_NE(refused.exitCode, 0);
  EXPECT_NE(refused.err.find("U+001B"), std::string::npos) << refused.err;
  EXPECT_EQ(refused.err.find('\033'), std::string::npos);
  // A file's name may have what a body's may not.
  fs::copy_file(folder_ / "fx" / "cube.obj", folder_ / "a\033[31mb\xE2\x80\xAE.obj");
  ASSERT_EQ(run("sweep a*b*.obj -m fx/rest.json -o a.t4d").exitCode, 0);
  EXPECT_NE(run("info a.t4d").out.find("body 'a_[31mb_'"), std::string::npos);
  EXPECT_EQ(run("slice a.t4d --time \"$(printf '\\033[31m')\"").err.find('\033'),
            std::string::npos);
  write("long.json", R"({"segments": [{"duration": ")" + std::string(100'000, 'x') + R"("}]})");
  write("key.json", R"({")" + std::string(100'000, 'x') + R"(": 1, "segments": []})");
  for (const char* motion : {"long.json", "key.json"}) {
    const Finished done = run(std::string("sweep fx/cube.obj -o out.t4d -m ") + motion);
    EXPECT_EQ(done.exitCode, 4);
    EXPECT_LT(done.err.size(), 3000U);
  }
}

TEST_F(Program, ACellLimitIsRaisedByItsOption) {
  ASSERT_EQ(run("sweep fx/cube.obj -m fx/rest.json -o a.t4d").exitCode, 0);
  for (const char* verb : {"validate a.t4d", "slice a.t4d --time 0.5 -o s.ply",
                           "flipbook a.t4d --frames 3 -o f.glb", "compare a.t4d a.t4d"}) {
    SCOPED_TRACE(verb);
    const Finished refused = run(std::string(verb) + " --max-cells 100");
    EXPECT_EQ(refused.exitCode, 4) << refused.err;
    EXPECT_NE(refused.err.find("try: --max-cells"), std::string::npos) << refused.err;
    EXPECT_EQ(run(std::string(verb) + " --max-cells 1000000").exitCode, 0);
  }
}

TEST_F(Program, CompareTakesNamesThatLookLikeOptions) {
  fs::copy_file(folder_ / "fx" / "cube.obj", folder_ / "-c.obj");
  EXPECT_EQ(run("compare -m fx/rest.json --voxel-size 4 --frames 2 --slices 2 -- -c.obj").exitCode,
            0);
}

TEST_F(Program, HelpIsAVerb) {
  EXPECT_EQ(run("help slice").out, run("slice --help").out);
  EXPECT_EQ(run("help").out, run("--help").out);
}

TEST_F(Program, OutputThatIsClosedEarlyEndsItQuietly) {
  shell("{ sleep 0.5; $t4d version 2> said; echo $? > code; } | true");
  EXPECT_EQ(contents(folder_ / "code"), "0\n");
  EXPECT_EQ(contents(folder_ / "said"), "");
  // Nobody reads the messages: the work is done all the same.
  write("long.json",
        R"({"segments": [{"duration": 1, "repeat": 60000, "translation": [0, 0, 1]}]})");
  shell(
      "{ $t4d sweep fx/torus.obj -m long.json --caps cone -o long.t4d > log; echo $? > code; } "
      "2>&1 | true");
  EXPECT_EQ(contents(folder_ / "code"), "0\n");
  EXPECT_EQ(run("info long.t4d --json").value()["slabs"], 60'002);
}

TEST_F(Program, OneThingIsNoMore) {
  ASSERT_EQ(run("sweep fx/cube.obj -m fx/rest.json --steps 1 -o one.t4d").exitCode, 0);
  EXPECT_THAT(run("slice one.t4d --time 0").out, testing::HasSubstr(", 1 slab\n"));
  EXPECT_THAT(run("info one.t4d").out, testing::HasSubstr(" in 3 slabs\n"));
  EXPECT_THAT(run("flipbook one.t4d --frames 1 -o a.glb").out, testing::HasSubstr(": 1 frame of"));
}

TEST_F(Program, AStepThatTurnsFarHasANote) {
  const std::string base = "sweep fx/cube.obj -m fx/paper-screw.json -o a.t4d --steps ";
  EXPECT_THAT(run(base + "1").err, testing::HasSubstr("t4d: note: a step of segment 0 turns by "));
  EXPECT_EQ(run(base + "8").err, "");
}

TEST_F(Program, EveryTruncationAndEveryAlteredByteIsFound) {
  ASSERT_EQ(run("sweep fx/cube.obj -m fx/rest.json -o whole.t4d").exitCode, 0);
  const std::string whole = contents(folder_ / "whole.t4d");
  // The library's tests try all of them; here a sample goes through the program.
  for (std::size_t i = 0; i < whole.size(); i += 1 + whole.size() / 60) {
    write("bad.t4d", whole.substr(0, i));
    EXPECT_EQ(run("info bad.t4d").exitCode, 4) << "cut at " << i;
    EXPECT_EQ(run("slice bad.t4d --time 0").exitCode, 4) << "cut at " << i;
    const Finished validated = run("validate bad.t4d --json");
    EXPECT_EQ(validated.exitCode, 4) << "cut at " << i;
    EXPECT_EQ(validated.value()["valid"], false);
    std::string altered = whole;
    altered[i] = static_cast<char>(altered[i] ^ 0x10);
    write("bad.t4d", altered);
    const Finished judged = run("validate bad.t4d --json");
    EXPECT_EQ(judged.exitCode, 4) << "altered at " << i;
    EXPECT_TRUE(judged.value()["issues"]["messages"][0]["offset"].is_number()) << judged.out;
  }
}

TEST_F(Program, LossIsListedAndExit3) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  const Finished lost = run("slice cube.t4d --time 1 --attributes -o a.stl");
  EXPECT_EQ(lost.exitCode, 3);
  EXPECT_NE(lost.err.find("triangle"), std::string::npos);
  EXPECT_NE(lost.err.find("kind"), std::string::npos);
  EXPECT_EQ(run("slice cube.t4d --time 1 --attributes -o a.ply").exitCode, 0);
}

/// Compares the peak memory that the program reports.
TEST_F(Program, MemoryDoesNotGrowWithTheMotion) {
  write("one.json", R"({"segments": [{"duration": 1, "axis_direction": [1, 0, 0],
                       "angle_degrees": 360, "translation": [20, 0, 0]}]})");
  write("ten.json", R"({"segments": [{"duration": 1, "axis_direction": [1, 0, 0],
                       "angle_degrees": 360, "translation": [20, 0, 0], "repeat": 10}]})");
  const auto peak = [&](const std::string& motion) {
    return run("sweep fx/bolt.obj -m " + motion + " -o m.t4d --json").value()["peak_bytes"];
  };
  EXPECT_LT(peak("ten.json").get<double>(), 1.1 * peak("one.json").get<double>());
}

TEST_F(Program, ComparesBothBackendsOnOneSolid) {
  const std::string both =
      "compare fx/paper-cube.obj -m fx/paper-translation.json --voxel-size 2.5 --frames 9 ";
  const Finished done = run(both + "--slices 3 --keep kept --html page.html --json");
  ASSERT_EQ(done.exitCode, 0) << done.err;
  const json value = done.value();
  EXPECT_EQ(value["a"]["backend"], "mesh4d");
  EXPECT_EQ(value["b"]["backend"], "voxel4d");
  EXPECT_EQ(value["a"]["vertices"], 4750);
  EXPECT_EQ(value["a"]["tetrahedra"], 21552);
  for (const char* mesh : {"a", "b"}) {
    for (const char* key : {"bytes", "seconds", "peak_bytes", "hypervolume"}) {
      EXPECT_GT(value[mesh][key].get<double>(), 0) << mesh << " " << key;
    }
    EXPECT_NEAR(value[mesh]["hypervolume_expected"].get<double>(), 512000, 1e-6);
  }
  EXPECT_NEAR(value["a"]["hypervolume_error"].get<double>(), 0, 1e-12);
  EXPECT_LT(value["b"]["hypervolume_error"].get<double>(), 0);
  ASSERT_EQ(value["slices"].size(), 3U);
  for (const json& slice : value["slices"]) {
    // At these times the cube's faces lie on the lattice: only edges and corners are cut off.
    const double lost = slice["volume_a"].get<double>() - slice["volume_b"].get<double>();
    EXPECT_NEAR(slice["volume_a"].get<double>(), 8000, 1e-9);
    EXPECT_GT(lost, 0);
    EXPECT_NEAR(slice["symmetric_difference"].get<double>(), lost, 1e-3 * lost);
    EXPECT_GT(slice["area_a"], slice["area_b"]);
    EXPECT_LT(slice["hausdorff"].get<double>(), 2.5 * std::sqrt(3));
  }
  EXPECT_EQ(value["slices"][2]["time"], 64);

  const std::string page = contents(folder_ / "page.html");
  EXPECT_NE(page.find("<svg"), std::string::npos);
  EXPECT_NE(page.find("data:image/png;base64,iVBOR"), std::string::npos);
  for (const char* outside : {"http:", "https:", "<script", "<link"}) {
    EXPECT_EQ(page.find(outside), std::string::npos) << outside;
  }

  // The same two meshes as files: the same slices, and nothing about how they were made.
  const json files = run("compare kept/paper-cube-mesh4d.t4d kept/paper-cube-voxel4d.t4d "
                         "--times 0:64:3 --json")
                         .value();
  EXPECT_EQ(files["slices"], value["slices"]);
  EXPECT_EQ(files["b"]["tetrahedra"], value["b"]["tetrahedra"]);
  EXPECT_TRUE(files["a"]["seconds"].is_null() && files["b"]["peak_bytes"].is_null());
}

TEST_F(Program, ComparingWithItselfFindsNothing) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  const json value = run("compare cube.t4d cube.t4d --json").value();
  ASSERT_EQ(value["slices"].size(), 9U);
  for (const json& slice : value["slices"]) {
    EXPECT_EQ(slice["symmetric_difference"], 0);
    EXPECT_EQ(slice["hausdorff"], 0);
  }
  EXPECT_NE(run("compare cube.t4d cube.t4d").out.find("4,750"), std::string::npos);
}

TEST_F(Program, CompareSaysWhatIsWrong) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  EXPECT_EQ(run("compare cube.t4d").exitCode, 2);
  EXPECT_EQ(run("compare cube.t4d cube.t4d --frames 3").exitCode, 2);
  EXPECT_EQ(run("compare cube.t4d cube.t4d --times 0:1:0").exitCode, 2);
  refuses("compare cube.t4d cube.t4d --times 60:70:2", "last from 0 to 64");
  refuses("compare cube.t4d fx/cube.obj", "fx/cube.obj");
  const std::string rest = " --voxel-size 1 --frames 9 --html out.glb";
  refuses("compare fx/cube.obj -m nothing.json" + rest, "nothing.json");
  refuses("compare fx/nothing.obj -m fx/rest.json" + rest, "nothing.obj");
  misused("compare fx/cube.obj -m fx/rest.json --voxel-size 1 --frames 1",
          "--frames: '1' is not a whole number from 2 to 1000000");
}

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

TEST_F(Program, CompareConvertsUnits) {
  // The same cube and motion in mm and s, in m and min, and in unknown units.
  const auto make = [&](const std::string& name, const char* length, const char* time,
                        const std::string& scale, const std::string& duration) {
    std::string obj;
    for (const char* corner :
         {"0 0 0", "S 0 0", "S S 0", "0 S 0", "0 0 S", "S 0 S", "S S S", "0 S S"}) {
      obj += std::string("v ") + corner + "\n";
    }
    for (std::size_t at = 0; (at = obj.find('S')) != std::string::npos;) obj.replace(at, 1, scale);
    write(name + ".obj",
          obj + "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
    write(name + ".json", std::string(R"({"length_unit": ")") + length + R"(", "time_unit": ")" +
                              time + R"(", "segments": [{"duration": )" + duration +
                              R"(, "translation": [)" + scale + ", 0, 0]}]}");
    ASSERT_EQ(run("sweep " + name + ".obj -m " + name + ".json -o " + name + ".t4d").exitCode, 0);
  };
  make("small", "mm", "s", "500", "90");
  make("large", "m", "min", "0.5", "1.5");
  make("odd", "cubit", "s", "1", "90");
  const Finished done = run("compare small.t4d large.t4d --slices 4 --json --html page.html");
  ASSERT_EQ(done.exitCode, 0) << done.err;
  EXPECT_THAT(done.err, testing::HasSubstr("lengths of large.t4d are converted from m to mm"));
  EXPECT_THAT(done.err, testing::HasSubstr("times of large.t4d are converted from min to s"));
  const json value = done.value();
  EXPECT_EQ(value["length_unit"], "mm");
  EXPECT_EQ(value["time_unit"], "s");
  EXPECT_NEAR(value["b"]["hypervolume"].get<double>(), 1.25e8 * 90, 1);
  ASSERT_EQ(value["slices"].size(), 4U);
  for (const json& slice : value["slices"]) {
    EXPECT_NEAR(slice["volume_b"].get<double>(), 1.25e8, 1e-4);
    EXPECT_NEAR(slice["area_b"].get<double>(), 1.5e6, 1e-6);
    EXPECT_NEAR(slice["symmetric_difference"].get<double>(), 0, 1e-3);
    EXPECT_NEAR(slice["hausdorff"].get<double>(), 0, 1e-9);
  }
  EXPECT_THAT(contents(folder_ / "page.html"), testing::HasSubstr("[mm³]"));
  const json back = run("compare large.t4d small.t4d --slices 4 --json").value();
  EXPECT_EQ(back["length_unit"], "m");
  EXPECT_NEAR(back["b"]["hypervolume"].get<double>(), 0.125 * 1.5, 1e-12);
  refuses("compare small.t4d odd.t4d", "its length unit is 'cubit' and that of small.t4d is 'mm'");
  EXPECT_EQ(run("compare odd.t4d odd.t4d --slices 1").exitCode, 0);
  ASSERT_EQ(run(kPaper).exitCode, 0);
  EXPECT_THAT(run("compare small.t4d cube.t4d --times 0:1:2").err,
              testing::HasSubstr("only small.t4d states a length unit, mm"));
}

TEST_F(Program, CompareShowsTheConvergence) {
  const Finished done =
      run("compare fx/icosphere.obj -m fx/paper-translation.json --voxel-size 4,2 --voxel-size 8 "
          "--slices 2 --keep kept --csv all.csv --html page.html --json");
  ASSERT_EQ(done.exitCode, 0) << done.err;
  const json value = done.value();
  EXPECT_EQ(value["b"]["voxel_size"], 2);
  const json& levels = value["convergence"]["levels"];
  ASSERT_EQ(levels.size(), 3U);
  EXPECT_EQ(levels[0]["voxel_size"], 8);
  EXPECT_EQ(levels[1]["frames"], 17);
  EXPECT_GT(levels[1]["symmetric_difference"], levels[2]["symmetric_difference"]);
  EXPECT_GT(value["convergence"]["order_symmetric_difference"].get<double>(), 1);
  EXPECT_TRUE(fs::exists(folder_ / "kept" / "icosphere-voxel4d-4.t4d"));
  const std::string csv = contents(folder_ / "all.csv");
  EXPECT_EQ(
      csv.substr(0, csv.find('\n')),
      "voxel_size,frames,time,volume_a,volume_b,area_a,area_b,symmetric_difference,hausdorff");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 3 * 2);
  EXPECT_THAT(contents(folder_ / "page.html"), testing::HasSubstr("order of convergence"));
}

TEST_F(Program, FramesMayBeLeftOut) {
  const std::string turn = " -m fx/paper-translation.json --voxel-size 4 ";
  const json series = run("voxelize fx/paper-cube.obj" + turn + "-o frames --json").value();
  EXPECT_EQ(series["frames"], 17);
  const Finished swept =
      run("sweep fx/paper-cube.obj --backend voxel4d" + turn + "-o all.t4d --json");
  EXPECT_EQ(swept.value()["steps"], 16);
  EXPECT_EQ(swept.err, "");
  const Finished few =
      run("sweep fx/paper-cube.obj --backend voxel4d" + turn + "--frames 5 -o few.t4d");
  EXPECT_THAT(few.err, testing::HasSubstr("points move up to 4 voxels between two frames; 17 "
                                          "frames over the whole motion would keep them"));
  EXPECT_EQ(few.exitCode, 0);
  refuses("voxelize fx/cube.obj -m fx/paper-translation.json --voxel-size 1e-6 -o out",
          "at most 1000000 are allowed; use larger voxels, or choose the number of frames");
}

TEST_F(Program, CompareSaysWhenTimesFallOnFrames) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  EXPECT_THAT(run("compare cube.t4d cube.t4d --slices 9").err,
              testing::HasSubstr("all comparison times are layers of a and layers of b"));
  EXPECT_EQ(run("compare cube.t4d cube.t4d --slices 10").err, "");
}

TEST_F(Program, CompareTakesTimesThatDoNotBeatWithSteps) {
  write("turn.json", R"({"segments": [{"duration": 1, "axis_direction": [0, 0, 1],
                                       "angle_degrees": 360}]})");
  ASSERT_EQ(run("sweep fx/cube.obj -m turn.json --steps 12 -o turn.t4d").exitCode, 0);
  const json slices = run("compare turn.t4d turn.t4d --json").value()["slices"];
  ASSERT_EQ(slices.size(), 9U);
  EXPECT_EQ(slices[0]["time"], 0);
  EXPECT_EQ(slices[8]["time"], 1);
  for (std::size_t i = 2; i < 8; ++i) {
    EXPECT_NEAR(slices[i]["volume_a"].get<double>(), slices[1]["volume_a"].get<double>(), 1e-6);
  }
}

TEST_F(Program, SweepStatesItsDeviationAndHalfTurns) {
  write("turns.csv", "t,qx,qy,qz,qw\n0,0,0,0,1\n1,0,0,1,0\n2,0,0,0,-1\n");
  const Finished done =
      run("sweep fx/cube.obj -m turns.csv --max-deviation 0.5 --json -o turns.t4d");
  ASSERT_EQ(done.exitCode, 0) << done.err;
  EXPECT_THAT(done.err, testing::HasSubstr("turns.csv: 2 pairs of poses, the first lines 2 and 3, "
                                           "are half a turn apart"));
  const json value = done.value();
  EXPECT_LE(value["chord_bound"].get<double>(), 0.5);
  EXPECT_GT(value["chord_bound"].get<double>(), 0.25);
  EXPECT_EQ(value["half_turns"]["count"], 2);
  EXPECT_EQ(value["half_turns"]["first"][1]["between"], "lines 3 and 4");
  EXPECT_THAT(run("sweep fx/cube.obj -m turns.csv --max-deviation 0.5 -o turns.t4d").out,
              testing::HasSubstr("every slice within 0."));
  refuses("sweep fx/cube.obj -m turns.csv --max-deviation 1e-300 -o none.t4d",
          "turns.csv: the motion needs");
}

/// Section 5.1, the voxel method.
TEST_F(Program, PaperVoxelCubeByWayOfFiles) {
  ASSERT_EQ(run("voxelize fx/paper-cube.obj -m fx/paper-voxel.json --voxel-size 1 --frames 64 "
                "--mask -o frames")
                .exitCode,
            0);
  const json woven = run("weave frames -o woven.t4d --json").value();
  EXPECT_EQ(woven["vertices"], 197828);
  EXPECT_EQ(woven["tetrahedra"], 1185280);
  EXPECT_EQ(woven["frames"], 64);
  EXPECT_TRUE(woven.contains("seconds") && woven.contains("peak_bytes"));
  const json valid = run("validate woven.t4d --json").value();
  EXPECT_EQ(valid["valid"], true);
  EXPECT_EQ(valid["closed"], true);
  EXPECT_EQ(run("info woven.t4d --json").value()["backend"], "voxel4d");
  const json direct = run("sweep fx/paper-cube.obj -m fx/paper-voxel.json --backend voxel4d "
                          "--voxel-size 1 --frames 64 --mask -o direct.t4d --json")
                          .value();
  EXPECT_EQ(direct["vertices"], 197828);
  EXPECT_EQ(direct["tetrahedra"], 1185280);
}

TEST_F(Program, GradedCapsHaveFewerCellsAndTheSameSlices) {
  const std::string sweep =
      "sweep fx/icosphere.obj -m fx/rest.json --backend voxel4d --voxel-size 0.25 --frames 2 ";
  const Finished flat = run(sweep + "-o flat.t4d --json");
  const Finished graded = run(sweep + "--caps graded -o graded.t4d --json");
  EXPECT_THAT(flat.err, testing::HasSubstr("tetrahedra are in the flat caps; graded caps"));
  EXPECT_EQ(graded.err, "");
  for (const std::size_t end : {0U, 1U}) {
    EXPECT_LT(graded.value()["cap_tetrahedra"][end].get<double>(),
              0.4 * flat.value()["cap_tetrahedra"][end].get<double>());
  }
  EXPECT_EQ(run("validate graded.t4d").exitCode, 0);
  EXPECT_EQ(run("info graded.t4d --json").value()["details"]["parameters"]["caps"], "graded");
  ASSERT_EQ(run("slice flat.t4d --time 3.7 -o flat.stl").exitCode, 0);
  ASSERT_EQ(run("slice graded.t4d --time 3.7 -o graded.stl").exitCode, 0);
  EXPECT_EQ(contents(folder_ / "flat.stl"), contents(folder_ / "graded.stl"));
}

TEST_F(Program, GridsToMeshToGridsKeepsTheVolume) {
  const std::string motion = " -m fx/skew-axis.json --voxel-size 0.5 --frames 9 ";
  ASSERT_EQ(run("sweep fx/torus.obj --backend voxel4d" + motion + "-o a.t4d").exitCode, 0);
  ASSERT_EQ(run("rasterize a.t4d --voxel-size 0.5 --frames 9 -o frames").exitCode, 0);
  ASSERT_EQ(run("weave frames -o b.t4d").exitCode, 0);
  const double end = run("info a.t4d --json").value()["time_end"];
  for (const double time : {0.0, 0.3 * end, end}) {
    const std::string at = " --json --time " + std::to_string(time);
    const double a = run("slice a.t4d" + at).value()["volume"];
    const double b = run("slice b.t4d" + at).value()["volume"];
    EXPECT_NEAR(a, b, 0.05 * a);
  }
}

TEST_F(Program, AFolderOfFramesHasItsNameHoweverItIsWritten) {
  ASSERT_EQ(
      run("voxelize fx/cube.obj -m fx/rest.json --voxel-size 4 --frames 2 -o frames/").exitCode, 0);
  for (const char* folder : {"frames", "frames/", "./frames/.", "fx/../frames"}) {
    ASSERT_EQ(run(std::string("weave ") + folder + " -o woven.t4d").exitCode, 0) << folder;
    const json info = run("info woven.t4d --json").value();
    EXPECT_EQ(info["bodies"][0]["name"], "frames") << folder;
    EXPECT_EQ(info["details"]["source"]["frames"], "frames") << folder;
  }
}

/// Also of several bodies, and what a transformed mesh encloses.
TEST_F(Program, TransformsKeepWhatAMeshIs) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  const double hypervolume = run("validate cube.t4d --json").value()["hypervolume"];
  const auto moved = [&](const std::string& options) {
    const json done = run("transform cube.t4d -o moved.t4d --json " + options).value();
    const json report = run("validate moved.t4d --json").value();
    EXPECT_TRUE(report["valid"]) << options;
    EXPECT_LT(fs::file_size(folder_ / "moved.t4d"), 2 * fs::file_size(folder_ / "cube.t4d"));
    return std::pair(done, report["hypervolume"].get<double>() / hypervolume);
  };
  EXPECT_NEAR(moved("--rotate 1 2 3 40 --move 1 2 3").second, 1, 1e-12);
  EXPECT_NEAR(moved("--scale 2 3 -0.5 --time-scale 4").second, 12, 1e-11);
  const auto [done, ratio] =
      moved("--axes y-xz --matrix 1 1 0 5 0 1 0 0 0 0 2 0 --time-shift 7.25");
  EXPECT_NEAR(ratio, 2, 1e-12);
  EXPECT_EQ(done["matrix"], json::array({-1., 1., 0., 5., -1., 0., 0., 0., 0., 0., 2., 0.}));
  EXPECT_EQ(run("info moved.t4d --json").value()["time_begin"], 7.25);
  EXPECT_NEAR(moved("--rotate 1e200 0 0 90").second, 1, 1e-12);
  // The cube moves along z by one in each unit of time: backward, and with z and t exchanged.
  EXPECT_EQ(run("transform cube.t4d --axes xyz-t -o back.t4d").exitCode, 3);
  EXPECT_NEAR(run("validate back.t4d --json").value()["hypervolume"], 512000, 1e-6);
  EXPECT_NEAR(run("slice back.t4d --time -3.25 --json").value()["volume"], 8000, 1e-8);
  EXPECT_EQ(run("transform cube.t4d --axes xytz -o turned.t4d").exitCode, 3);
  EXPECT_TRUE(run("validate turned.t4d --json").value()["valid"]);
  EXPECT_NEAR(run("slice turned.t4d --time 30.7 --json").value()["volume"], 8000, 1e-8);
  refuses("transform cube.t4d --move 1e17 0 0 -o out.t4d", "doubles are too coarse there");
  refuses("transform cube.t4d --time-shift 1e17 -o out.t4d", "both become");
  placeFixture(folder_, "cube", 1, 1000);
  ASSERT_EQ(run("sweep cube-placed.obj -m fx/rest.json --center -o c.t4d").exitCode, 0);
  const json origin = run("info c.t4d --json").value()["details"]["origin"];
  ASSERT_EQ(run("transform c.t4d --scale 2 -o c2.t4d").exitCode, 0);
  const json doubled = run("info c2.t4d --json").value()["details"]["origin"];
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(doubled[axis].get<double>(), 2 * origin[axis].get<double>());
  }
  misused("transform cube.t4d --axes xxz -o out.t4d", "--axes");
  misused("transform cube.t4d --scale 0 -o out.t4d", "leaves no solid");
  misused("transform cube.t4d --rotate 0 0 0 5 -o out.t4d", "the axis is 0 0 0");
  misused("transform cube.t4d --time-scale -1 -o out.t4d", "--time-scale");
  misused("transform cube.t4d -o cube.t4d", "cube.t4d");
}

TEST_F(Program, PartsOfTheTimeAddUp) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  // The paper's cube moves by one in each unit of time: 8000 is its volume.
  double before = 0;
  for (const double time : {0.7, 2.1, 20.0, 63.999, 64.0}) {
    const json done = run("filter cube.t4d --from " + std::to_string(before) + " --to " +
                          std::to_string(time) + " -o part.t4d --json")
                          .value();
    EXPECT_EQ(done["time_begin"], before);
    EXPECT_EQ(done["time_end"], time);
    const json report = run("validate part.t4d --json").value();
    EXPECT_TRUE(report["valid"]);
    EXPECT_TRUE(report["closed"]);
    EXPECT_NEAR(report["hypervolume"], 8000 * (time - before), 1e-6);
    before = time;
  }
  EXPECT_EQ(run("filter cube.t4d -o whole.t4d").exitCode, 0);
  EXPECT_EQ(run("diff cube.t4d whole.t4d --json").value()["level"], "bytes");
  refuses("filter cube.t4d --from 64 -o out.t4d", "the mesh lasts from time 0 to 64");
  misused("filter cube.t4d --from 2 --to 2 -o out.t4d", "--from 2 is not before --to 2");
  refuses("filter cube.t4d --body paper-cub -o out.t4d", "did you mean paper-cube?");
}

TEST_F(Program, DiffTellsBytesMeshAndSolidApart) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  const auto level = [&](const std::string& other, int exitCode) {
    const Finished done = run("diff cube.t4d " + other + " --json");
    EXPECT_EQ(done.exitCode, exitCode) << done.err;
    return json::parse(done.out)["level"].get<std::string>();
  };
  EXPECT_EQ(level("cube.t4d", 0), "bytes");
  ASSERT_EQ(run("compress cube.t4d -o small.t4d").exitCode, 0);
  EXPECT_LT(fs::file_size(folder_ / "small.t4d"), fs::file_size(folder_ / "cube.t4d"));
  EXPECT_EQ(level("small.t4d", 0), "mesh");
  ASSERT_EQ(run("compress cube.t4d --grid-step 0.01 -o rounded.t4d").exitCode, 0);
  EXPECT_NE(level("rounded.t4d", 0), "different");
  ASSERT_EQ(run("transform cube.t4d --move 1 0 0 -o moved.t4d").exitCode, 0);
  EXPECT_EQ(level("moved.t4d", 1), "different");
  EXPECT_EQ(level("moved.t4d --tolerance 1.01", 0), "solid");
  refuses("diff cube.t4d fx/cube.obj", "not a .t4d file");
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

/// labels.nrrd: two balls with labels 1 and 2, and voxels that are no cubes.
TEST_F(Program, VolumesAreWoven) {
  double parts = 0;
  for (const char* label : {"1", "2"}) {
    const std::string output = std::string("ball") + label + ".t4d";
    ASSERT_EQ(run("weave fx/labels.nrrd --label " + std::string(label) + " -o " + output).exitCode,
              0);
    const json report = run("validate " + output + " --json").value();
    EXPECT_TRUE(report["closed"] && report["oriented"]);
    parts += report["hypervolume"].get<double>();
  }
  ASSERT_EQ(run("weave fx/labels.nrrd --label 1 2 -o two.t4d").exitCode, 0);
  const json bodies = run("validate two.t4d --json").value();
  EXPECT_TRUE(bodies["valid"]);
  EXPECT_NEAR(bodies["hypervolume"], parts, 1e-12 * parts);
  EXPECT_EQ(run("info two.t4d --json").value()["bodies"][1]["name"], "label 2");
  // Anything above 0 is both of them.
  ASSERT_EQ(run("weave fx/labels.nrrd --iso 0.5 -o both.t4d").exitCode, 0);
  const json info = run("info both.t4d --json").value();
  EXPECT_EQ(info["time_end"], 0.5);
  EXPECT_EQ(info["length_unit"], "mm");
  EXPECT_EQ(info["time_unit"], "s");
  ASSERT_EQ(
      run("weave fx/labels.nrrd --iso 0.5 --frame-time 1 --spacing 1 --origin 0 0 0 -o unit.t4d")
          .exitCode,
      0);
  refuses("weave fx/labels.nrrd -o out.t4d", "an iso value or a label must be given");
  refuses("weave fx/labels.nrrd --label 7 -o out.t4d", "no sample of any frame is 7");
  write("bare.raw", std::string(16, '\1'));
  refuses("weave bare.raw --frame-time 1 -o out.t4d", "does not begin with a line");
  ASSERT_EQ(run("weave bare.raw --raw 'bool 2 2 2 2' --frame-time 1 -o bare.t4d").exitCode, 0);
  misused("weave fx/labels.nrrd one.vdb --iso 1 -o out.t4d", "are not of one kind");
  misused("weave frames --label 1 -o out.t4d", "--label");
  misused("weave frames --substeps 4 -o out.t4d", "--substeps requires --velocity");
  misused("weave frames --velocity estimate -o out.t4d", "cannot be estimated");
  misused("weave frames --velocity v --between distance -o out.t4d", "--between is for masks");
  misused("weave fx/labels.nrrd --label 1 --velocity-file a.npy b.npy c.npy -o out.t4d",
          "--label makes masks");
  misused("weave frames --velocity-file a.npy b.npy c.npy -o out.t4d", "--velocity GRID");
  misused("weave fx/labels.nrrd --label 1 --velocity v -o out.t4d", "--velocity is for .vdb files");
  misused("weave fx/labels.nrrd --label 99999999999999999999 -o out.t4d", "--label");
  misused("weave fx/labels.nrrd --label 3 3 -o out.t4d", "--label: a label is given twice");
  misused("weave fx/labels.nrrd --axes xxyz -o out.t4d", "is not an order of x, y, z, t and c");
  misused("weave fx/labels.nrrd --spacing 1 2 -o out.t4d", "--spacing is one length, or three");
}

/// However the place of a lattice is given, one too far for doubles is refused, and the file named.
TEST_F(Program, FarVolumesAreRefused) {
  const std::string weave = "weave fx/labels.nrrd --label 1 ";
  ASSERT_EQ(run(weave + "-o near.t4d").exitCode, 0);
  const double expected = run("validate near.t4d --json").value()["hypervolume"];
  ASSERT_EQ(run(weave + "--origin 1e6 -1e7 1e6 -o away.t4d").exitCode, 0);
  EXPECT_NEAR(run("validate away.t4d --json").value()["hypervolume"], expected, 1e-6 * expected);
  for (const char* away : {"1e11", "1e16", "1e17", "1e40"}) {
    for (const std::string& origin : {std::string(away) + " 0 0", "0 0 -" + std::string(away)}) {
      refuses(weave + "--origin " + origin + " -o out.t4d", "fx/labels.nrrd: frame 0: lies up to");
    }
  }
  refuses(weave + "--spacing 1e-12 -o out.t4d", "voxels from the origin of space");
  refuses(weave + "--spacing 1e-80 --origin 0 0 0 -o out.t4d", "fx/labels.nrrd");
  refuses("weave fx/cube.obj fx/cube.obj --voxel-size 1e-9 -o out.t4d", "fx/cube.obj");
}

TEST_F(Program, VolumesOfPatientsSayWhereTheAxesPoint) {
  const auto withSpace = [&](const std::string& space, const std::string& name) {
    std::string header = "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 3 3 3 2\n";
    if (!space.empty()) header += "space: " + space + "\n";
    header += "space directions: (1,0,0) (0,1,0) (0,0,2) none\nencoding: text\n\n";
    for (int i = 0; i < 54; ++i) header += i % 27 == 13 ? "1 " : "0 ";
    write(name, header);
  };
  withSpace("LPS", "brain.nrrd");
  withSpace("left-anterior-superior", "las.nrrd");
  withSpace("", "none.nrrd");
  const auto woven = [&](const std::string& name, const std::string& options = "") {
    return run("weave " + name + " --label 1 -o out.t4d " + options);
  };
  EXPECT_THAT(woven("brain.nrrd").out,
              testing::HasSubstr("positions are LPS: x to the left, y posterior, z superior"));
  EXPECT_EQ(run("info out.t4d --json").value()["up"], "z");
  EXPECT_EQ(run("info out.t4d --json").value()["bodies"][0]["name"], "brain");
  EXPECT_THAT(contents(folder_ / "out.t4d"), testing::HasSubstr(R"("space": "LPS")"));
  EXPECT_EQ(woven("brain.nrrd", "--up y --json").value()["space"], "LPS");
  EXPECT_EQ(run("info out.t4d --json").value()["up"], "y");
  EXPECT_THAT(woven("las.nrrd").err, testing::HasSubstr("x is negated"));
  EXPECT_THAT(contents(folder_ / "out.t4d"), testing::HasSubstr(R"("space": "RAS")"));
  EXPECT_EQ(woven("none.nrrd", "--json").value()["space"], nullptr);
  EXPECT_EQ(run("info out.t4d --json").value()["up"], "y");
  EXPECT_THAT(woven("none.nrrd").err,
              testing::HasSubstr("frames are taken to be 1 apart; give the time between frames"));
  EXPECT_EQ(woven("none.nrrd", "--frame-time 2").err, "");
  EXPECT_THAT(contents(folder_ / "out.t4d"), testing::Not(testing::HasSubstr("\"space\"")));
}

TEST_F(Program, BodiesAreNamedWithoutAllExtensions) {
  ASSERT_EQ(run("weave fx/labels.nrrd --label 1 -o labels.t4d").exitCode, 0);
  // A header of 352 bytes, three axes, bytes: see the tests of volumes.
  std::string nifti(352, '\0');
  const auto put = [&](std::size_t at, std::string bytes) {
    nifti.replace(at, bytes.size(), bytes);
  };
  put(0, {"\x5C\1\0\0", 4});
  put(40, {"\4\0\3\0\3\0\3\0\2\0", 10});
  put(70, {"\2\0\x8\0", 4});
  for (const std::size_t at : {80, 84, 88, 92}) put(at, {"\0\0\x80\x3F", 4});
  put(108, {"\0\0\xB0\x43", 4});
  put(344, "n+1");
  for (int i = 0; i < 54; ++i) nifti += i % 27 == 13 ? '\1' : '\0';
  write("brain.nii", nifti);
  write("a.b.nii", nifti);
  ASSERT_EQ(shell("gzip -k brain.nii && cp brain.nii.gz a.tar.nii.gz && cp brain.nii.gz T.NII.GZ"),
            0);
  for (const auto& [file, name] : std::map<std::string, std::string>{{"brain.nii", "brain"},
                                                                     {"brain.nii.gz", "brain"},
                                                                     {"a.b.nii", "a.b"},
                                                                     {"a.tar.nii.gz", "a.tar"},
                                                                     {"T.NII.GZ", "T"}}) {
    ASSERT_EQ(run("weave " + file + " --label 1 -o out.t4d").exitCode, 0) << file;
    EXPECT_EQ(run("info out.t4d --json").value()["bodies"][0]["name"], name);
  }
  fs::remove(folder_ / "out.t4d");
  refuses("slice brain.nii.gz --time 0", "t4d weave brain.nii.gz -o brain.t4d");
}

/// Nobody writes into these pipes: a verb that opened one would wait for ever.
TEST_F(Program, PipesAreNoInputsButOfFilesThatAreReadOnce) {
  ASSERT_EQ(run("sweep fx/cube.obj --motion fx/rest.json -o mesh.t4d").exitCode, 0);
  for (const char* extension :
       {"obj",  "stl",  "ply", "off",  "gltf", "glb",    "vtp", "vtu", "pvd",
        "msh",  "fbx",  "dae", "json", "csv",  "nc",     "cl",  "pc2", "mdd",
        "nrrd", "nhdr", "npy", "raw",  "nii",  "nii.gz", "hdr", "vdb", "t4d"}) {
    const std::string pipe = std::string("pipe.") + extension;
    SCOPED_TRACE(pipe);
    ASSERT_EQ(shell("mkfifo " + pipe), 0);
    for (const std::string command :
         {"weave P -o out.t4d", "weave P fx/cube.obj --voxel-size 1 -o out.t4d",
          "sweep P --motion fx/rest.json -o out.t4d", "sweep fx/cube.obj --motion P -o out.t4d",
          "sweep fx/cube.obj P --frame-time 1 -o out.t4d", "sweep P P -o out.t4d",
          "mill fx/cube.obj --tool P --motion fx/rest.json --voxel-size 4 -o out.t4d",
          "convert P out.t4d", "slice P --time 0 -o out.stl", "diff P mesh.t4d", "diff mesh.t4d P",
          "mend P -o out.ply", "compare P mesh.t4d"}) {
      std::string line = command;
      for (auto at = line.find('P'); at != line.npos; at = line.find('P'))
        line.replace(at, 1, pipe);
      EXPECT_GT(shell("timeout 10 $t4d " + line + " > /dev/null 2> err"), 0) << line;
      EXPECT_LT(shell("timeout 10 $t4d " + line + " > /dev/null 2> err"), 124) << line;
    }
  }
}

TEST_F(Program, ACollectionIsASeriesWithItsTimes) {
  ASSERT_EQ(run("sweep fx/bending_*.obj --frame-time 0.25 -o mesh.t4d").exitCode, 0);
  ASSERT_EQ(run("frames mesh.t4d --count 5 --light -o out/a_%d.vtp").exitCode, 0);
  const Finished swept = run("sweep out/a.pvd -o swept.t4d");
  EXPECT_EQ(swept.exitCode, 0) << swept.err;
  EXPECT_THAT(swept.err, testing::Not(testing::HasSubstr("1 apart")));
  const Finished woven = run("weave out/a.pvd --voxel-size 2 -o woven.t4d");
  EXPECT_EQ(woven.exitCode, 0) << woven.err;
  for (const char* name : {"swept.t4d", "woven.t4d"}) {
    const auto info = nlohmann::json::parse(run(std::string("info --json ") + name).out);
    EXPECT_EQ(info["time_begin"], 0) << name;
    EXPECT_EQ(info["time_end"], 2) << name;
  }
  ASSERT_EQ(run("weave out/a.pvd --voxel-size 2 --frame-time 3 -o woven.t4d").exitCode, 0);
  EXPECT_EQ(nlohmann::json::parse(run("info --json woven.t4d").out)["time_end"], 12);
  for (const char* command :
       {"weave out/a.pvd -o out.t4d", "weave out/a.pvd out/a_0.vtp --voxel-size 2 -o out.t4d",
        "weave out/a.pvd --voxel-size 2 --start-time 1 -o out.t4d",
        "sweep out/a.pvd out/a_0.vtp -o out.t4d", "sweep out/a.pvd -m fx/rest.json -o out.t4d"}) {
    EXPECT_EQ(run(command).exitCode, 2) << command;
    EXPECT_FALSE(fs::exists(folder_ / "out.t4d")) << command;
  }
  // A mesh that is missing is found before the others are woven.
  ASSERT_EQ(shell("rm out/a_3.vtp"), 0);
  for (const char* command :
       {"weave out/a.pvd --voxel-size 2 -o out.t4d", "sweep out/a.pvd -o out.t4d"}) {
    const Finished refused = run(command);
    EXPECT_EQ(refused.exitCode, 4) << command;
    EXPECT_EQ(refused.err, "t4d: out/a.pvd:8: names the file 'a_3.vtp': no such file\n") << command;
  }
}

/// A sphere as .obj, of `around` by `across` quadrilaterals and triangles at the poles.
std::string ballText(double radius, double x, int around, int across) {
  std::string text;
  const auto point = [&](double height, double angle) {
    const double ring = radius * std::sin(height);
    text += "v " + std::to_string(x + ring * std::cos(angle)) + " " +
            std::to_string(ring * std::sin(angle)) + " " +
            std::to_string(radius * std::cos(height)) + "\n";
  };
  const double pi = std::acos(-1.0);
  point(0, 0);
  for (int i = 1; i < across; ++i) {
    for (int j = 0; j < around; ++j) point(pi * i / across, 2 * pi * j / around);
  }
  point(pi, 0);
  const auto at = [&](int i, int j) { return 2 + (i - 1) * around + j % around; };
  const int last = 2 + (across - 1) * around;
  const auto face = [&](std::initializer_list<int> corners) {
    text += "f";
    for (const int corner : corners) text += " " + std::to_string(corner);
    text += "\n";
  };
  for (int j = 0; j < around; ++j) {
    face({1, at(1, j), at(1, j + 1)});
    for (int i = 1; i + 1 < across; ++i) {
      face({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
    }
    face({at(across - 1, j), last, at(across - 1, j + 1)});
  }
  return text;
}

TEST_F(Program, MeshesOfAnyTrianglesAreWoven) {
  // A ball of radius 4 that moves by less than a voxel between frames, with other triangles in
  // each.
  constexpr int kFrames = 11;
  fs::create_directory(folder_ / "by-hand");
  for (int i = 0; i < kFrames; ++i) {
    const std::string name = "ball_" + std::to_string(i);
    write(name + ".obj", ballText(4, 0.4 * i, 60 + 7 * i, 40 + 3 * (i % 4)));
    ASSERT_EQ(
        run("voxelize " + name + ".obj -m fx/rest.json --voxel-size 0.5 --frames 2 -o " + name)
            .exitCode,
        0);
    fs::copy(folder_ / name / "frame_0000.vdb", folder_ / "by-hand" / (name + ".vdb"));
  }
  const Finished done =
      run("weave ball_*.obj --voxel-size 0.5 --frame-time 0.25 -o balls.t4d --json");
  EXPECT_EQ(done.value()["frames"], kFrames);
  EXPECT_EQ(done.err, "");
  const json report = run("validate balls.t4d --deep --json").value();
  EXPECT_TRUE(report["valid"] && report["closed"] && report["oriented"]);
  // The meshes have up to 0.4 % less than the ball, voxels change 1 %.
  const double ball = 4 * std::acos(-1.0) / 3 * 64;
  EXPECT_NEAR(report["hypervolume"], 2.5 * ball, 0.015 * 2.5 * ball);
  const json info = run("info balls.t4d --json").value();
  EXPECT_EQ(info["time_end"], 2.5);
  EXPECT_EQ(info["details"]["parameters"]["voxel_size"], 0.5);
  EXPECT_EQ(info["details"]["source"]["meshes"], kFrames);
  // Grids made by hand give the same mesh.
  ASSERT_EQ(run("weave by-hand --frame-time 0.25 --body ball_0 -o by-hand.t4d").exitCode, 0);
  const json same = run("diff balls.t4d by-hand.t4d --json").value();
  EXPECT_THAT(same["level"], testing::AnyOf("bytes", "mesh"));

  const std::string first = "weave ball_0.obj ";
  EXPECT_THAT(run(first + "ball_1.obj --voxel-size 1 -o unit.t4d").err,
              testing::HasSubstr("frames are taken to be 1 apart"));
  misused(first + "ball_1.obj -o out.t4d", "need --voxel-size");
  misused(first + "by-hand/ball_1.vdb --voxel-size 1 -o out.t4d", "are not of one kind");
  misused(first + "ball_1.obj --voxel-size 1 --iso 1 -o out.t4d", "not for triangle meshes");
  misused("weave by-hand --voxel-size 1 -o out.t4d", "--voxel-size is for triangle meshes");
  refuses(first + "--voxel-size 1 -o out.t4d", "ball_0.obj: one frame only");
  refuses(first + "ball_2.obj --voxel-size 1 -o out.t4d", "number 1 is missing");
  const std::string text = contents(folder_ / "ball_1.obj");
  write("ball_1.obj", text.substr(0, text.rfind("f ")));
  refuses(first + "ball_1.obj --voxel-size 1 -o out.t4d", "ball_1.obj: the mesh is open");
  write("ball_1.obj", "v 0 0 nan\n" + text);
  refuses(first + "ball_1.obj --voxel-size 1 -o out.t4d", "ball_1.obj:1: ");
  write("ball_1.obj", text + "f 1 3 2\n");
  refuses(first + "ball_1.obj --voxel-size 1 -o out.t4d", "ball_1.obj: ");
  EXPECT_THAT(run("weave ball_2.obj ball_3.obj --voxel-size 20 --frame-time 1 -o wide.t4d").err,
              testing::HasSubstr("larger than the solid of ball_2.obj"));
}

/// A box of 2 x 3 x 4 cm that moves for a second, turns by 90 degrees in the next, and by as much
/// in the two after it.
constexpr const char* kMovingBox = R"(<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2020-01-01T00:00:00</created><modified>2020-01-01T00:00:00</modified>
<unit name="centimetre" meter="0.01"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g" name="g"><mesh><source id="p">
<float_array id="pa" count="24">0 0 0 2 0 0 0 3 0 2 3 0 0 0 4 2 0 4 0 3 4 2 3 4</float_array>
<technique_common><accessor source="#pa" count="8" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<polylist count="6"><input semantic="VERTEX" source="#v" offset="0"/><vcount>4 4 4 4 4 4</vcount>
<p>0 2 3 1 4 5 7 6 0 1 5 4 2 6 7 3 0 4 6 2 1 3 7 5</p></polylist></mesh></geometry>
</library_geometries><library_animations><animation id="r">
<source id="rt"><float_array id="rta" count="4">0 1 2 4</float_array><technique_common>
<accessor source="#rta" count="4" stride="1"><param name="TIME" type="float"/></accessor>
</technique_common></source>
<source id="rv"><float_array id="rva" count="4">0 0 90 180</float_array><technique_common>
<accessor source="#rva" count="4" stride="1"><param name="ANGLE" type="float"/></accessor>
</technique_common></source>
<source id="xv"><float_array id="xva" count="4">0 3 3 3</float_array><technique_common>
<accessor source="#xva" count="4" stride="1"><param name="X" type="float"/></accessor>
</technique_common></source>
<source id="i"><Name_array id="ia" count="4">LINEAR LINEAR LINEAR LINEAR</Name_array>
<technique_common><accessor source="#ia" count="4" stride="1">
<param name="INTERPOLATION" type="name"/></accessor></technique_common></source>
<sampler id="rs"><input semantic="INPUT" source="#rt"/><input semantic="OUTPUT" source="#rv"/>
<input semantic="INTERPOLATION" source="#i"/></sampler>
<sampler id="xs"><input semantic="INPUT" source="#rt"/><input semantic="OUTPUT" source="#xv"/>
<input semantic="INTERPOLATION" source="#i"/></sampler>
<channel source="#rs" target="box/turn.ANGLE"/><channel source="#xs" target="box/at.X"/>
</animation></library_animations>
<library_visual_scenes><visual_scene id="s" name="s"><node id="box" name="box">
<translate sid="at">0 5 7</translate><rotate sid="turn">0 0 1 0</rotate>
<instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>
)";

TEST_F(Program, ColladaIsSwept) {
  if (run("formats").out.find("COLLADA") == std::string::npos) GTEST_SKIP() << "without Assimp";
  write("box.dae", kMovingBox);
  const Finished swept = run("sweep box.dae --tolerance 1e-5 -o box.t4d --json");
  EXPECT_EQ(swept.err, "");
  EXPECT_EQ(swept.value()["bodies"][0]["name"], "box");
  const json report = run("validate box.t4d --deep --json").value();
  EXPECT_TRUE(report["valid"] && report["closed"] && report["oriented"]);
  // 24 cm^3 for 4 s. Steps that turn by a lose (1 - cos a) / 3 of it, and the tolerance keeps a
  // below 0.048.
  const double whole = 96e-6;
  EXPECT_LE(report["hypervolume"].get<double>(), whole * (1 + 1e-6));
  EXPECT_GE(report["hypervolume"].get<double>(), whole * (1 - 4e-4));
  const json info = run("info box.t4d --json").value();
  EXPECT_EQ(info["time_end"], 4);
  EXPECT_EQ(info["length_unit"], "m");
  EXPECT_EQ(info["time_unit"], "s");
  // At a key it is the box, turned by 90 degrees.
  EXPECT_NEAR(run("slice box.t4d --time 2 --json").value()["volume"], 24e-6, 1e-11);
  write("box.dae", std::string(kMovingBox).substr(0, 1500));
  refuses("sweep box.dae -o out.t4d", "box.dae: ");
}

TEST_F(Program, BadFramesAreRefused) {
  ASSERT_EQ(run("voxelize fx/cube.obj -m fx/rest.json --voxel-size 1 --frames 2 -o two").exitCode,
            0);
  fs::create_directories(folder_ / "none");
  fs::create_directories(folder_ / "one");
  fs::copy_file(folder_ / "two" / "frame_0000.vdb", folder_ / "one" / "frame_0000.vdb");
  const std::string whole = contents(folder_ / "two" / "frame_0001.vdb");
  write("cut.vdb", whole.substr(0, whole.size() / 2));
  const std::string first = "weave two/frame_0000.vdb ";
  refuses("weave none -o out.t4d", "none");
  refuses("weave one -o out.t4d", "one frame only");
  misused("weave fx/cube.obj fx/torus.obj -o out.t4d", "need --voxel-size");
  refuses(first + "cut.vdb -o out.t4d", "cut.vdb");
  refuses(first + "two/frame_0000.vdb -o out.t4d", "times do not increase");
  refuses("weave two --iso 1000 -o out.t4d", "1000");
  const std::string voxels = "sweep fx/cube.obj -m fx/rest.json --backend voxel4d -o out.t4d ";
  misused(voxels + "--voxel-size 0 --frames 3", "--voxel-size: '0' is not a number above 0");
  misused(voxels + "--voxel-size 1 --frames 1", "--frames: '1'");
  misused(voxels + "--voxel-size 1 --frame-time inf", "--frame-time: 'inf'");
  misused("voxelize fx/cube.obj -m fx/rest.json --voxel-size 1 --frames 1 -o out", "--frames: '1'");
}

TEST_F(Program, MemoryDoesNotGrowWithTheFrames) {
  const auto peak = [&](const std::string& frames) {
    return run("sweep fx/icosphere.obj -m fx/paper-screw.json --backend voxel4d --voxel-size 0.5 "
               "--threads 1 -o m.t4d --json --frames " +
               frames)
        .value()["peak_bytes"]
        .get<double>();
  };
  EXPECT_LT(peak("200"), 1.15 * peak("20"));
}

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
    // Neither open nor crossing, nor flat anywhere, as it is read again.
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
  for (const std::string size : {"--voxel-size 1.5", ""}) {
    const std::string envelope = "envelope turning.t4d --json " + size;
    const json whole = run(envelope + options("")).value();
    const int most = run(envelope + " --most-parts").value()["parts"];
    for (const int count : size.empty() ? std::vector{2} : std::vector{1, 3, most}) {
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
  refuses(fine + "no.vdb", "0.61 fits, and so may parts of them (--part)");
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
  misused("join v-1.vdb v-2.vdb", "name the field (.vdb) of all parts");
  misused("join v-1.vdb v-2.vdb -o no.t4d", "name the field (.vdb) of all parts");
  misused("join v-1.vdb cube.t4d -o no.vdb", "not joined with other files");
  misused("join v-1.vdb v-2.vdb --manifest -o no.t4dm", "are for meshes (.t4d)");
  misused("join v-1.vdb v-2.vdb -o v-1.vdb", "is the input itself");
  EXPECT_FALSE(fs::exists(folder_ / "no.vdb"));
}

TEST_F(Program, EnvelopeOfSeveralBodiesIsOfAllOrOfEach) {
  ASSERT_EQ(run("sweep fx/two-boxes.obj -m fx/paper-translation.json -o boxes.t4d").exitCode, 0);
  const json two = run("envelope boxes.t4d --voxel-size 1 --json").value();
  EXPECT_EQ(two["components"], 2);
  // Two cubes of side 2 that overlap by half, as bodies.
  const std::string faces =
      "f -8 -6 -5 -7\nf -4 -3 -1 -2\nf -8 -7 -3 -4\nf -6 -2 -1 -5\nf -8 -4 -2 -6\nf -7 -5 -1 -3\n";
  const auto corners = [](int x) {
    std::string text;
    for (int i = 0; i < 8; ++i) {
      text += fmt::format("v {} {} {}\n", x + 2 * (i & 1), 2 * (i >> 1 & 1), 2 * (i >> 2));
    }
    return text;
  };
  write("two.obj", "o a\n" + corners(0) + faces + "o b\n" + corners(1) + faces);
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
          "would need about 5605.8 GiB of memory, more than 4 GiB; 0.038 fits");
  refuses("envelope cube.t4d --voxel-size 0.05 --visits no.vdb", "0.064 fits");
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
    return json::parse(run("envelope --json " + arguments).out).at("chord_bound");
  };
  EXPECT_GT(boundOf("screw.t4d --voxel-size 4"), 0);
  EXPECT_TRUE(boundOf("curve.t4d --voxel-size 0.004").is_null());
  EXPECT_TRUE(boundOf("far.t4d --voxel-size 0.004").is_null());
  EXPECT_EQ(run("envelope curve.t4d --voxel-size 0.004 --outside").exitCode, 3);
  const auto pair = [&](const std::string& files) {
    return json::parse(run("collide --ignore-units --json " + files).out).at("pairs").at(0);
  };
  EXPECT_TRUE(pair("curve.t4d far.t4d").at("chord_bound").is_null());
  EXPECT_TRUE(pair("screw.t4d far.t4d").at("chord_bound").is_null());
  EXPECT_FALSE(pair("screw.t4d screw.t4d").at("chord_bound").is_null());
  const auto resolved =
      json::parse(run("resolve far.t4d screw.t4d --ignore-units --json -o out.t4d").out);
  EXPECT_TRUE(resolved.at("chord_bound").is_null());
}

/// A box as .obj.
std::string boxText(const std::array<double, 3>& low, const std::array<double, 3>& high) {
  std::string text;
  for (int i = 0; i < 8; ++i) {
    text += fmt::format("v {} {} {}\n", (i & 1) != 0 ? high[0] : low[0],
                        (i & 2) != 0 ? high[1] : low[1], (i & 4) != 0 ? high[2] : low[2]);
  }
  return text + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
}

constexpr const char* kTurn =
    R"({"segments": [{"duration": 1, "axis_direction": [0, 0, 1], "angle_degrees": 170}]})";

TEST_F(Program, EnvelopeStatesHowFarTheMeshIsFromTheMotion) {
  ASSERT_EQ(run("sweep fx/cube.obj -m fx/skew-axis.json --steps 6 -o turning.t4d").exitCode, 0);
  ASSERT_EQ(run("sweep fx/cube.obj -m fx/rest.json -o still.t4d").exitCode, 0);
  ASSERT_EQ(run("transform still.t4d --move 500 0 0 -o far.t4d").exitCode, 0);
  const json pair = run("collide turning.t4d far.t4d --ignore-units --json").value()["pairs"][0];
  const json near = run("envelope turning.t4d --json").value();
  EXPECT_GT(near["chord_bound"].get<double>(), 0);
  EXPECT_EQ(near["chord_bound"], pair["chord_bound"]);
  EXPECT_EQ(near["outside"], false);
  EXPECT_TRUE(near["outside_by"].is_null());
  EXPECT_EQ(run("envelope still.t4d --json").value()["chord_bound"], 0);
  // Rounded coordinates are beside the motion, too.
  ASSERT_EQ(run("compress far.t4d --precision float32 -o single.t4d").exitCode, 0);
  const double rounding = run("envelope single.t4d --json").value()["chord_bound"];
  EXPECT_GT(rounding, 0x1p-24 * 500);
  EXPECT_LT(rounding, 1e-3);
  const json rounded = run("collide turning.t4d single.t4d --ignore-units --json").value();
  EXPECT_NEAR(rounded["pairs"][0]["chord_bound"], double(near["chord_bound"]) + rounding, 1e-12);
  EXPECT_THAT(run("envelope turning.t4d").out, testing::HasSubstr("of the motion"));
  for (const std::string format : {"ply", "stl", "glb"}) {
    const Finished made = run("envelope turning.t4d --outside --json -o out2." + format);
    EXPECT_EQ(made.exitCode, 0) << made.err;
    const json outside = made.value();
    EXPECT_GT(outside["volume"], near["volume"]);
    EXPECT_GT(outside["outside_by"], outside["chord_bound"]);
    EXPECT_EQ(outside["self_intersections"], 0);
    EXPECT_EQ(run("mend out2." + format + " -o again.ply --json").value()["changes"].size(), 0U);
  }
  EXPECT_THAT(run("envelope turning.t4d --outside").out,
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
  const Finished unknown = run("envelope voxels.t4d --outside --json");
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
  EXPECT_THAT(none.err, testing::HasSubstr("--exact or --outside needs no voxels as small"));
  EXPECT_NEAR(run("envelope sheet.t4d --exact --json").value()["volume"].get<double>(), 120, 1e-6);
  EXPECT_EQ(run("envelope sheet.t4d --outside --voxel-size 3 --json").value()["components"], 1);
}

TEST_F(Program, CollideNeverContradictsItsClearance) {
  write("turn.json", kTurn);
  write("stay.json", R"({"segments": [{"duration": 1}]})");
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
      // What is printed supports the answer.
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
  write("stay.json", R"({"segments": [{"duration": 1}]})");
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
    std::ofstream(folder_ / "arm.srdf") << text;
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
  const Finished swept = run("simplify cube.t4d --ratio 0.5 -o half.t4d");
  EXPECT_EQ(swept.exitCode, 0);
  EXPECT_NE(swept.err.find("is small as it is"), std::string::npos) << swept.err;
  EXPECT_TRUE(
      run("simplify cube.t4d --ratio 0.5 --json -o half.t4d").value()["max_error"].is_null());
  EXPECT_EQ(run("simplify cube.t4d --ratio 0.5 --html page.html -o half.t4d").exitCode, 0);
  for (const char* said : {"<h2>The solids</h2>", "b: half.t4d, by its distance from a"}) {
    EXPECT_NE(contents(folder_ / "page.html").find(said), std::string::npos) << said;
  }
  ASSERT_EQ(run("transform cube.t4d --time-scale 1e9 -o slow.t4d").exitCode, 0);
  const Finished needles = run("simplify slow.t4d --ratio 0.5 --time-scale 1 -o half.t4d");
  EXPECT_NE(needles.err.find("is a better scale"), std::string::npos) << needles.err;
  misused("simplify cube.t4d --ratio 0.5 --html half.t4d -o half.t4d", "two outputs");
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
  misused(mill + "--voxel-size 1 -o out.t4d --html ./out.t4d", "two outputs are the same file");
  misused(mill + "--voxel-size 1 -o out.t4d --html " + (folder_ / "fx/../out.t4d").string(),
          "two outputs are the same file");
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
  misused(mill + "--tool 1=flat:d=6,l=30 --tool flat:d=6,l=30 -o out.t4d",
          "with and without a number");
  misused(mill + "--tool 1=flat:d=6,l=30 --holder 2=d=9,l=9 -o out.t4d", "there is no tool 2");
  misused(all + "--rotary A=table --rotary A=head -o out.t4d", "--rotary: A is given twice");
  misused(all + "--offset G60=1,2,3 -o out.t4d", "--offset: 'G60=1,2,3' is no offset");
  misused(
      "mill fx/cube.obj --tool flat:d=6,l=30 --motion fx/rest.json --tcp --voxel-size 4 -o out.t4d",
      "are for --gcode");
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

TEST_F(Program, ObjectsOfAnObjAreBodies) {
  const std::string box =
      "f -8 -6 -5 -7\nf -4 -3 -1 -2\nf -8 -7 -3 -4\nf -6 -2 -1 -5\nf -8 -4 -2 -6\nf -7 -5 -1 -3\n";
  const auto corners = [](double x, double side) {
    std::string text;
    for (int i = 0; i < 8; ++i) {
      text += fmt::format("v {} {} {}\n", x + side * (i & 1), side * (i >> 1 & 1), side * (i >> 2));
    }
    return text;
  };
  // They overlap, and one lacks a side.
  write("two.obj", "o small part\ng a\n" + corners(0, 1) + box + "o large\ng b\n" +
                       corners(0.5, 2) + box.substr(0, box.rfind("f ")));
  const json mended = run("mend two.obj --bodies object -o mended.obj --json").value();
  EXPECT_NEAR(mended["volume_after"].get<double>(), 9, 1e-12);
  EXPECT_EQ(mended["components"], 2);
  EXPECT_NE(mended["changes"][0]["text"].get<std::string>().find("body 'large': filled"),
            std::string::npos);
  for (const std::string from : {"mended.obj --bodies object", "two.obj --mend --bodies object"}) {
    const json swept =
        run("sweep " + from + " -m fx/paper-translation.json -o two.t4d --json").value();
    ASSERT_EQ(swept["bodies"].size(), 2U);
    EXPECT_EQ(swept["bodies"][0]["name"], "small part");
    EXPECT_EQ(swept["bodies"][1]["name"], "large");
    const json info = run("info two.t4d --json").value();
    EXPECT_EQ(info["bodies"][1]["name"], "large");
    const json slice = run("slice two.t4d --time 5 --json").value();
    EXPECT_NEAR(slice["volume"].get<double>(), 9, 1e-9);
  }
  refuses("sweep two.obj --bodies object -m fx/rest.json -o out.t4d", "body 'large'");
  refuses("sweep fx/open-pebble.stl --bodies object -m fx/rest.json -o out.t4d", "is no .obj");
  misused("sweep fx/bending_*.obj --bodies group --frame-time 1 -o out.t4d", "--bodies");
}

TEST_F(Program, RealMeshesAreJudged) {
  const fs::path meshes = T4D_SHARED_MESHES;
  if (!fs::exists(meshes)) GTEST_SKIP() << "no folder " << meshes << " with real meshes";
  const auto sweep = [&](const std::string& mesh) {
    return "sweep " + (meshes / mesh).string() + " -m fx/paper-screw.json --rv-min 0.9976 ";
  };
  refuses(sweep("cube_no_bottom.obj") + "-o out.t4d", "open: 8 boundary edges");
  refuses(sweep("wingnut.obj") + "-o out.t4d", ", or --caps cone");
  EXPECT_EQ(run(sweep("wingnut.obj") + "--mend -o nut.t4d").exitCode, 0);
  EXPECT_EQ(run(sweep("cube_no_bottom.obj") + "--mend -o cube.t4d").exitCode, 0);
  refuses(
      sweep("wingnut.obj") + "-o out.t4d",
      "3 pairs of triangles do (counted from 0: 3106 with 4372, 3490 with 4372, 4306 with 4372)");
  EXPECT_EQ(run(sweep("wingnut.obj") + "--caps cone -o nut.t4d").exitCode, 0);
  const json nut = run("validate nut.t4d --json").value();
  EXPECT_EQ(nut["valid"], true);
  const double expected = 22.0966389286 * 100 * (2 + std::cos(2 * M_PI / 65)) / 3;
  EXPECT_NEAR(nut["hypervolume"].get<double>(), expected, 1e-9 * expected);

  const json fish = run(sweep("fish.obj") + "-o fish.t4d --json").value();
  EXPECT_EQ(fish["steps"], 65);
  EXPECT_EQ(fish["tetrahedra"], 14 * 21568 * 65 + fish["cap_tetrahedra"][0].get<int>() +
                                    fish["cap_tetrahedra"][1].get<int>());
  const double raw = 32 * fish["vertices"].get<double>() + 16 * fish["tetrahedra"].get<double>();
  EXPECT_LT(static_cast<double>(fs::file_size(folder_ / "fish.t4d")), raw / 20);
}

}  // namespace
}  // namespace t4d::tools
