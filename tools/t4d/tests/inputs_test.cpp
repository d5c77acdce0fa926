#include <algorithm>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "tools/t4d/tests/program.h"

/// No verb replaces a file that it reads, whatever it is called, or a file of another kind than it
/// writes.
namespace t4d::tools {
namespace {

using testing::HasSubstr;

/// A run of a verb.
struct Verb {
  std::string arguments;            ///< but for the output
  std::vector<std::string> inputs;  ///< all files that it reads
  std::string output;               ///< its option, with a blank; none for a positional
  std::string extension;            ///< of the output
};

class Inputs : public Program {
 protected:
  void SetUp() override {
    Program::SetUp();
    for (const std::string& command :
         {std::string(kPaper), std::string("sweep fx/cube.obj -m fx/rest.json -o rest.t4d"),
          std::string("sweep fx/cube.obj -m fx/paper-screw.json --part 1/2 -o p1.t4d"),
          std::string("sweep fx/cube.obj -m fx/paper-screw.json --part 2/2 -o p2.t4d"),
          std::string("join p1.t4d p2.t4d --manifest -o m.t4dm"),
          std::string("voxelize fx/cube.obj -m fx/rest.json --voxel-size 4 --frames 2 -o grids"),
          std::string("envelope cube.t4d --voxel-size 1 --visits v1.vdb --part 1/2"),
          std::string("envelope cube.t4d --voxel-size 1 --visits v2.vdb --part 2/2"),
          std::string("slice cube.t4d --time 0 -o at.gltf"),
          std::string("frames cube.t4d --count 4 --part 1/2 --format ply -o frames"),
          std::string("frames cube.t4d --count 4 --part 2/2 --format ply -o frames")}) {
      const Finished done = run(command);
      ASSERT_EQ(done.exitCode, 0) << command << done.err;
    }
    for (const char* part : {"1", "2"}) {
      const Finished done =
          run(std::string("measure cube.t4d --frames 4 --json --part ") + part + "/2");
      write(std::string("r") + part + ".json", done.out);
    }
    write("times.csv", "time\n1\n2\n");
    write("tracks.json", R"({"tracks": [], "events": []})");
    write("speed.csv", "playback,time\n0,0\n1,2\n");
    writeVolumes();
    writeGltf();
  }

  /// Files of samples beside their headers, in folders, and in chunks.
  void writeVolumes() const {
    std::string samples(2 * 64, '\0');
    for (const std::size_t at : {21U, 22U, 64 + 21U}) samples[at] = 1;
    write("vol.samples", samples);
    write("v.nhdr",
          "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 4 4 4 2\nencoding: raw\n"
          "kinds: domain domain domain time\ndata file: vol.samples\n");
    fs::create_directories(folder_ / "npy");
    std::string header = "{'descr': '|u1', 'fortran_order': False, 'shape': (4, 4, 4), }";
    header.resize(117, ' ');
    header += '\n';
    for (const std::size_t frame : {0U, 1U}) {
      write("npy/f" + std::to_string(frame) + ".npy",
            std::string("\x93NUMPY\x01\x00\x76\x00", 10) + header + samples.substr(64 * frame, 64));
    }
  }

  /// A glTF file whose buffer is another file.
  void writeGltf() const {
    json gltf = json::parse(contents(folder_ / "at.gltf"));
    const std::string uri = gltf["buffers"][0]["uri"];
    write("buffer.b64", uri.substr(uri.find(',') + 1));
    ASSERT_EQ(shell("base64 -d buffer.b64 > b.bin"), 0);
    gltf["buffers"][0]["uri"] = "b.bin";
    write("ext.gltf", gltf.dump());
  }

  static std::vector<Verb> verbs() {
    const std::string o = "-o ";
    const std::string html = "--html ";
    const std::string weaving = "weave --label 1 --frame-time 1 ";
    return {
        {"sweep fx/cube.obj -m fx/rest.json", {"fx/cube.obj", "fx/rest.json"}, o, ".t4d"},
        {"sweep ext.gltf -m fx/rest.json", {"ext.gltf", "b.bin"}, o, ".t4d"},
        {"sweep fx/arm.json --caps cone", {"fx/arm.json"}, o, ".t4d"},
        {"weave grids", {"grids/frame_0000.vdb", "grids/frame_0001.vdb"}, o, ".t4d"},
        {weaving + "v.nhdr", {"v.nhdr", "vol.samples"}, o, ".t4d"},
        {weaving + "npy/f0.npy npy/f1.npy", {"npy/f0.npy", "npy/f1.npy"}, o, ".t4d"},
        {"mill fx/cube.obj --tool ball:d=6,l=30 -m fx/rest.json --voxel-size 4 --frames 2",
         {"fx/cube.obj", "fx/rest.json"},
         o,
         ".t4d"},
        {"mill fx/cube.obj --tool ball:d=6,l=30 -m fx/rest.json --voxel-size 4 --frames 2 -o x.t4d",
         {"fx/cube.obj", "fx/rest.json"},
         html,
         ".html"},
        {"slice m.t4dm --time 30", {"m.t4dm"}, o, ".ply"},
        {"slice cube.t4d --time 1", {"cube.t4d"}, o, ".glb"},
        {"flipbook cube.t4d --frames 2", {"cube.t4d"}, o, ".glb"},
        {"flipbook cube.t4d --times-file times.csv", {"times.csv"}, o, ".usda"},
        {"flipbook cube.t4d --speed-file speed.csv", {"speed.csv"}, o, ".glb"},
        {"compare cube.t4d rest.t4d --slices 1", {"cube.t4d", "rest.t4d"}, html, ".html"},
        {"compare fx/cube.obj -m fx/rest.json --voxel-size 4 --frames 2",
         {"fx/cube.obj", "fx/rest.json"},
         "--csv ",
         ".csv"},
        {"view cube.t4d", {"cube.t4d"}, o, ".html"},
        {"view cube.t4d --tracks tracks.json", {"tracks.json"}, o, ".html"},
        {"quality cube.t4d", {"cube.t4d"}, o, ".t4d"},
        {"quality cube.t4d", {"cube.t4d"}, html, ".html"},
        {"measure cube.t4d --times-file times.csv", {"cube.t4d", "times.csv"}, o, ".csv"},
        {"measure cube.t4d --times-file times.csv", {"cube.t4d", "times.csv"}, html, ".html"},
        {"track cube.t4d --times-file times.csv", {"cube.t4d", "times.csv"}, o, ".csv"},
        {"track cube.t4d --times-file times.csv", {"cube.t4d", "times.csv"}, "--events ", ".csv"},
        {"track cube.t4d --times-file times.csv", {"cube.t4d", "times.csv"}, "--samples ", ".csv"},
        {"track cube.t4d --times-file times.csv", {"cube.t4d", "times.csv"}, "--contacts ", ".csv"},
        {"collide cube.t4d rest.t4d --frames 2", {"cube.t4d", "rest.t4d"}, o, ".json"},
        {"collide cube.t4d rest.t4d --frames 2", {"cube.t4d", "rest.t4d"}, html, ".html"},
        {"collide cube.t4d rest.t4d", {"cube.t4d", "rest.t4d"}, "--matrix ", ".svg"},
        {"envelope cube.t4d --exact", {"cube.t4d"}, o, ".stl"},
        {"envelope cube.t4d --voxel-size 4", {"cube.t4d"}, html, ".html"},
        {"envelope cube.t4d --voxel-size 4", {"cube.t4d"}, "--visits ", ".vdb"},
        {"envelope cube.t4d --voxel-size 4", {"cube.t4d"}, "--dwell ", ".vdb"},
        {"envelope cube.t4d --voxel-size 4", {"cube.t4d"}, "--first ", ".vdb"},
        {"envelope cube.t4d --voxel-size 4", {"cube.t4d"}, "--last ", ".vdb"},
        {"recover cube.t4d", {"cube.t4d"}, o, ".t4d"},
        {"mend fx/crossing-balls.stl", {"fx/crossing-balls.stl"}, o, ".ply"},
        {"resolve rest.t4d cube.t4d", {"cube.t4d", "rest.t4d"}, o, ".t4d"},
        {"resolve rest.t4d cube.t4d -o x.t4d", {"cube.t4d", "rest.t4d"}, html, ".html"},
        {"join p1.t4d p2.t4d", {"p1.t4d", "p2.t4d"}, o, ".t4d"},
        {"join p1.t4d p2.t4d --manifest", {"p1.t4d", "p2.t4d"}, o, ".t4dm"},
        {"join m.t4dm", {"m.t4dm", "p1.t4d", "p2.t4d"}, o, ".t4d"},
        {"join v1.vdb v2.vdb", {"v1.vdb", "v2.vdb"}, o, ".vdb"},
        {"join r1.json r2.json", {"r1.json", "r2.json"}, o, ".json"},
        {"join frames/manifest.part-1-of-2.json frames/manifest.part-2-of-2.json",
         {"frames/manifest.part-1-of-2.json", "frames/manifest.part-2-of-2.json"},
         o,
         ".json"},
        {"merge cube.t4d rest.t4d", {"cube.t4d", "rest.t4d"}, o, ".t4d"},
        {"transform m.t4dm --scale 2", {"m.t4dm", "p1.t4d", "p2.t4d"}, o, ".t4d"},
        {"filter m.t4dm --from 20", {"m.t4dm", "p1.t4d", "p2.t4d"}, o, ".t4d"},
        {"simplify m.t4dm --ratio 0.9", {"m.t4dm", "p1.t4d", "p2.t4d"}, o, ".t4d"},
        {"simplify cube.t4d --ratio 0.9 -o x.t4d", {"cube.t4d"}, html, ".html"},
        {"compress m.t4dm", {"m.t4dm", "p1.t4d", "p2.t4d"}, o, ".t4d"},
        {"convert fx/24-cell.off", {"fx/24-cell.off"}, "", ".t4d"},
        {"convert m.t4dm", {"m.t4dm", "p1.t4d", "p2.t4d"}, "", ".vtu"},
        {"conform reader --reader true --only valid/one-simplex", {}, "--junit ", ".xml"},
        {"conform writer --writer true --only plain/one-simplex", {}, "--junit ", ".xml"},
        {"conform backends --list --case cube-at-rest", {}, html, ".html"},
    };
  }
};

TEST_F(Inputs, AreNeverReplacedUnderAnyName) {
  for (const Verb& verb : verbs()) {
    for (const std::string& input : verb.inputs) {
      const std::string output = "also" + verb.extension;
      SCOPED_TRACE(verb.arguments + " " + verb.output + output + " is " + input);
      const std::string before = contents(folder_ / input);
      ASSERT_FALSE(before.empty());
      fs::create_hard_link(folder_ / input, folder_ / output);
      misused(verb.arguments + " " + verb.output + output, output + ": is an input of this run");
      EXPECT_EQ(contents(folder_ / input), before);
      EXPECT_EQ(contents(folder_ / output), before);
      fs::remove(folder_ / output);
      if (verb.arguments.starts_with("join frames/")) continue;  // replaces no link at all
      fs::create_symlink(input, folder_ / output);
      misused(verb.arguments + " " + verb.output + output, "is an input of this run");
      EXPECT_EQ(contents(folder_ / input), before);
      EXPECT_TRUE(fs::is_symlink(folder_ / output));
      fs::remove(folder_ / output);
    }
  }
}

TEST_F(Inputs, AndFilesOfOtherKindsAreNeverReplaced) {
  for (const char* name : {"scan.nii.gz", "notes.txt", "thesis"}) write(name, "mine");
  for (const Verb& verb : verbs()) {
    for (const char* name : {"scan.nii.gz", "notes.txt", "thesis"}) {
      // A folder of the viewer has no extension.
      const bool isFolder = verb.arguments.starts_with("view");
      misused(verb.arguments + " " + verb.output + name,
              isFolder ? "name a page that ends in .html" : verb.extension);
      EXPECT_EQ(contents(folder_ / name), "mine");
    }
  }
}

/// Every option that names a file to write is in the table.
TEST_F(Inputs, OfAllVerbsAreTried) {
  std::map<std::string, std::set<std::string>> tried;
  for (const Verb& verb : verbs()) {
    const std::size_t second = verb.arguments.find(' ') + 1;
    const std::string name = verb.arguments.starts_with("conform ")
                                 ? verb.arguments.substr(0, verb.arguments.find(' ', second))
                                 : verb.arguments.substr(0, second - 1);
    tried[name].insert(verb.output.substr(0, verb.output.find(' ')));
  }
  const auto check = [&](const auto& self, const json& verb, const std::string& name) -> void {
    for (const json& below : verb["verbs"]) {
      self(self, below, (name.empty() ? "" : name + " ") + below["name"].get<std::string>());
    }
    for (const json& option : verb["options"]) {
      const std::string about = option["about"];
      const bool saysSo = about.starts_with("Output file") || about.starts_with("Write a ") ||
                          about.starts_with("Write the ");
      const std::string first = option["names"][0];
      if (saysSo && option["value"].is_string()) {
        EXPECT_TRUE(tried[name].contains(first)) << name << " " << first << ": " << about;
      }
    }
  };
  check(check, run("--help --json").value(), "");
  EXPECT_TRUE(tried["convert"].contains(""));
}

}  // namespace
}  // namespace t4d::tools
