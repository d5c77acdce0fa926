#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tools/t4d/tests/program.h"

/// What the program says about files that it does not read, or not as they are named.
namespace t4d::tools {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST_F(Program, NamesBeginNoLinesOfTheirOwn) {
  // The name begins a line as a message of the program would, and erases the line before it.
  const std::string name = "a\nt4d: done\x1b[2K.obj";
  const std::string shown = "a\\nt4d: done\\x1b[2K.obj";
  fs::copy(folder_ / "fx" / "cube.obj", folder_ / name);
  const Finished swept =
      run("sweep '" + name + "' --motion fx/rest.json --steps 1 -o '" + name + ".t4d'");
  EXPECT_EQ(swept.exitCode, 0) << swept.err;
  EXPECT_THAT(swept.out, testing::StartsWith(shown + ".t4d: "));
  EXPECT_THAT(run("info '" + name + ".t4d'").out, testing::StartsWith(shown + ".t4d: "));
  write(name, "nothing");
  const Finished refused = run("sweep '" + name + "' --motion fx/rest.json -o out.t4d");
  EXPECT_EQ(refused.exitCode, 4);
  EXPECT_THAT(refused.err, testing::StartsWith("t4d: " + shown));
  EXPECT_THAT(refused.err, Not(HasSubstr("\nt4d: done")));
}

TEST_F(Program, ModelsOfOtherProgramsHaveAWayIn) {
  std::vector<std::pair<std::string, std::string>> ways = {{"a.step", "in FreeCAD, mesh it"}};
  for (const std::string kind : {"fbx", "dae", "abc", "blend", "usd", "usda", "usdc", "usdz"}) {
    ways.emplace_back("a." + kind, "t4d: try: t4d-blender a." + kind +
                                       " -o a.t4d, or -o a.glb for the solid at rest\n");
  }
  for (const auto& [file, way] : ways) {
    write(file, std::string(100, '.'));
    for (const std::string rest :
         {"sweep F -o out.t4d", "sweep F --motion fx/rest.json -o out.t4d", "mend F -o out.ply",
          "slice F --time 0 -o out.glb", "weave F -o out.t4d", "convert F out.t4d"}) {
      std::string command = rest;
      refuses(command.replace(command.find(" F"), 2, std::string(" ") + file), way);
    }
  }
}

/// What Python's libraries read has a command, with the options of the one that was tried.
TEST_F(Program, FramesOfOtherKindsGoThroughPython) {
  fs::create_directories(folder_ / "scan");
  write("scan/IM 0001", std::string(128, '\0') + "DICM");
  fs::create_directories(folder_ / "store/0");
  write("store/zarr.json", "{}");
  for (const char* const file : {"a.tif", "a.h5", "a.mha", "a.vti", "a.npy"}) {
    write(file, std::string(100, '?'));
  }
  for (const auto& [words, kind] :
       {std::pair{"scan --iso 300 -o x.t4d", "scan: is DICOM"},
        {"'scan/IM 0001' scan --series 1.2 -o x.t4d", "scan/IM 0001: is DICOM"},
        {"store --level 1 --label=2 -o x.t4d", "store: is Zarr"},
        {"https://host/a.zarr/labels --dataset 0", "https://host/a.zarr/labels: is Zarr"},
        {"a.tif --axes tcyx --channel 1 -o x.t4d", "a.tif: is TIFF"},
        {"a.h5", "a.h5: is HDF5"},
        {"a.mha --iso=-3 -o x.t4d", "a.mha: is a medical image"},
        {"a.vti -o x.t4d", "a.vti: is a volume of VTK"},
        {"a.npy --velocity-file a.tif -o x.t4d", "a.tif: is TIFF"}}) {
    refuses(
        std::string("weave ") + words,
        fmt::format("t4d: {}, which Python's libraries read\nt4d: try: python3 -m t4d weave {}\n",
                    kind, words));
  }
  refuses("slice a.h5 --time 0 -o x.ply",
          "it is HDF5; make a 4D mesh of frames: python3 -m t4d weave a.h5 -o a.t4d");
  // Neither help nor the name of an output is an input.
  EXPECT_EQ(run("weave a.tif --help").exitCode, 0);
  EXPECT_THAT(run("weave a.npy -o a.tif").err, Not(HasSubstr("Python")));
  EXPECT_THAT(run("weave a.npy --channel 1 -o x.t4d").err,
              HasSubstr("--channel is for what python3 -m t4d weave reads"));
}

TEST_F(Program, StillModelsAreMovedByAMotion) {
  ASSERT_EQ(run("mend fx/cube.obj -o cube.glb").exitCode, 0);
  refuses("sweep cube.glb -o out.t4d", "cube.glb: has no animation\nt4d: try: --motion FILE");
  EXPECT_EQ(run("sweep cube.glb --motion fx/rest.json -o moved.t4d").exitCode, 0);
}

TEST_F(Program, CompressedGltfIsReadOrHasAWayIn) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  const Finished packed = run("slice cube.t4d --time 2 --meshopt -o packed.glb");
  if (packed.exitCode != 2) {
    ASSERT_EQ(packed.exitCode, 0) << packed.err;
    ASSERT_EQ(run("mend packed.glb -o mended.ply").exitCode, 0);
  }
  write("draco.gltf",
        R"({"asset":{"version":"2.0"},"meshes":[{"primitives":[{"attributes":{},"extensions":)"
        R"({"KHR_draco_mesh_compression":{"bufferView":0,"attributes":{"POSITION":0}}}}]}]})");
  refuses("mend draco.gltf -o out.ply",
          "draco.gltf: meshes[0].primitives[0]: is compressed by KHR_draco_mesh_compression and "
          "cannot be unpacked: buffer view 0 does not exist\n"
          "t4d: try: gltf-transform copy draco.gltf draco-plain.glb");
}

TEST_F(Program, AToolThatIsTooSmallIsAtFaultItself) {
  refuses(
      "mill fx/cube.obj --tool flat:d=1e-300,l=30 --motion fx/paper-translation.json --voxel-size "
      "1 --frames 3 -o out.t4d",
      "flat:d=1e-300,l=30: is 1e-300 wide");
}

TEST_F(Program, FramesNeedAPlaceForTheirNumber) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  misused("frames cube.t4d --frames 2 -o a%s.ply", "'a%s.ply' is neither a folder");
}

TEST_F(Program, NamesThatAreNotUtf8AreKeptAsFarAsJsonCan) {
  write("latin.obj",
        "o caf\xe9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n"
        "f 2 3 4\n");
  const Finished mended = run("mend latin.obj --bodies object -o named.glb");
  EXPECT_EQ(mended.exitCode, 3) << mended.err;
  EXPECT_THAT(mended.err, HasSubstr("that are not UTF-8"));
  ASSERT_EQ(run("sweep latin.obj --motion fx/rest.json --steps 1 -o p\xe9.t4d").exitCode, 0);
  const Finished named = run("join p\xe9.t4d --manifest -o all.t4dm");
  EXPECT_EQ(named.exitCode, 2) << named.err;
  EXPECT_THAT(named.err, HasSubstr("p\\xe9.t4d: has a name that is not UTF-8"));
  write("broken.t4dm", "{\"t4dm\": 1, ");
  refuses("info broken.t4dm", "broken.t4dm: is not JSON: parse error at line 1, column 13");
}

}  // namespace
}  // namespace t4d::tools
