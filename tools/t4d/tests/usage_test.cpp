#include <filesystem>
#include <string>

#include <gmock/gmock.h>

#include "tools/t4d/tests/program.h"

/// Words, help, messages and exit codes: what all verbs share.
namespace t4d::tools {
namespace {

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

TEST_F(Program, RefusesOptionsThatContradictEachOther) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  const std::string sweep = "sweep fx/cube.obj -m fx/rest.json -o out.t4d";
  misused("slice cube.t4d --x 0 --color time", "--color time: colours are those of a slice at");
  misused("slice cube.t4d -t 1 --max-speed 3", "--max-speed: needs --velocity or --color speed");
  misused("slice cube.t4d -t 1 --normals crease:200", "--normals: 'crease:200' is not flat");
  misused("slice cube.t4d --hyperplane 0,0,0,0,1", "--hyperplane: the hyperplane has the normal");
  misused("flipbook cube.t4d --rigid --color time -o a.glb", "--color time: a body of --rigid");
  misused("flipbook cube.t4d --visibility -o a.usda", "--visibility is for glTF");
  misused("frames cube.t4d -n 2 --light --color track -o o", "--color track: not with --light");
  misused("frames cube.t4d -n 2 --part 1/3 -o o", "--part: there are 2 frames, too few for 3");
  misused("frames cube.t4d -n 2 --part 1/2 --format usda -o o", "--part: USD frames come with");
  misused("envelope cube.t4d -o {body}.stl", "-o: a file per body, by {body}, needs --each");
  misused("envelope cube.t4d --each --first f.vdb", "--each: fields are of all bodies together");
  misused("envelope cube.t4d --exact --inflate 1 -o a.stl", "--outside, --inflate or --simplify");
  misused("envelope cube.t4d --part 1/2 -o a.stl", "--part divides the fields alone");
  misused("envelope cube.t4d --part 1/2", "--part divides the fields: give --visits");
  misused("envelope cube.t4d --from 3 --to 2 -o e.stl", "--from 3 is not before --to 2");
  misused("filter cube.t4d --from 3 --to 2 -o f.t4d", "--from 3 is not before --to 2");
  misused("transform cube.t4d --axes xxy -o x.t4d", "'xxy' is not x, y and z in some order");
  misused("transform cube.t4d --scale 1,0,1 -o x.t4d", "--scale: 0 leaves no solid");
  misused("transform cube.t4d --rotate 0,0,0,90 -o x.t4d", "--rotate: the axis is 0 0 0");
  misused("transform cube.t4d --matrix 1,0,0,0,0,1,0,0,0,0,0,0 -o x.t4d", "--matrix leaves no");
  misused("transform cube.t4d --time-scale -1 -o x.t4d", "--time-scale");
  misused("weave fx/labels.nrrd --part 2/2 --center -o w.t4d", "--part and --center exclude");
  misused(sweep + " --part 1/2 --center", "--part and --center exclude each other");
  misused("sweep fx/arm.json --part 1/2 -o a.t4d", "--part is not for a mechanism");
  misused("sweep fx/bending_0.obj fx/bending_1.obj --mend --max-move 1 -o a.t4d",
          "--remesh and --max-move are for --motion: mending a deformation moves no vertex");
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
  std::string bytes = contents(folder_ / "cube.t4d");
  for (const std::size_t at : {bytes.size() / 3, bytes.size() / 2}) {
    bytes[at] = static_cast<char>(bytes[at] ^ 16);
    write("flipped.t4d", bytes);
    EXPECT_THAT(run("validate flipped.t4d").err, testing::Not(testing::HasSubstr("slice it")));
    bytes[at] = static_cast<char>(bytes[at] ^ 16);
  }
  ASSERT_EQ(run("slice cube.t4d --time 0 -o slice.vtp").exitCode, 0);
  refuses("info slice.vtp", "it is a triangle mesh; sweep it first");
  refuses("convert slice.vtp out.t4d", "is not a 4D mesh in a known format");
  // A file that begins as a .t4d is one, whatever its name.
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
      const int exitCode = shell("timeout 10 $t4d " + line + " > /dev/null 2> err");
      EXPECT_GT(exitCode, 0) << line;
      EXPECT_LT(exitCode, 124) << line;
    }
  }
}

}  // namespace
}  // namespace t4d::tools
