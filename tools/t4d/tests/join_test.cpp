#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "tools/t4d/tests/program.h"

/// `t4d join` of meshes, and of reports.
namespace t4d::tools {
namespace {

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
  refuses("join a.t4d b.t4d --manifest -o no.t4d", "does not end with .t4dm", 2);
  refuses("join a.t4d --manifest -o fx/no.t4dm", "is not in the folder of", 2);
  refuses(sweep + "-o no.t4dm", "does not end with .t4d", 2);
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
  refuses("join a.t4d b.t4d -o a.t4d", "is an input of this run", 2);
  refuses("join -o no.t4d", "PART is required", 2);
  refuses("join a.t4d b.t4d -o no.t4d --plan", "--plan", 2);

  refuses(sweep + "--part 3/2 -o no.t4d", "'3/2' is not K/N", 2);
  refuses(sweep + "--part 1/2 --center -o no.t4d", "--part and --center", 2);
  refuses(sweep + "--steps 1 --part 1/1000 -o no.t4d", "too few for 1000 parts");
  refuses("slice - --time 1 -o no.ply", "standard input: slabs are read at their offsets");
}

/// A value, and the members and elements that lead to it.
using Place = json::json_pointer;

/// Places of a report: of long lists those in the first and the last element.
void addPlaces(const json& value, const Place& place, std::vector<Place>& places) {
  places.push_back(place);
  if (value.is_object()) {
    for (const auto& [name, member] : value.items()) addPlaces(member, place / name, places);
  }
  if (!value.is_array() || value.empty()) return;
  addPlaces(value.front(), place / 0, places);
  if (value.size() > 1) addPlaces(value.back(), place / (value.size() - 1), places);
}

/// The values that a value may become by mistake.
std::vector<json> mistakesOf(const json& value) {
  std::vector<json> mistakes;
  if (value.is_number()) mistakes.emplace_back(value.dump());
  if (value.is_boolean()) mistakes.emplace_back(!value.get<bool>());
  if (value.is_array() && !value.empty()) {
    json shorter = value;
    shorter.erase(0);
    json longer = value;
    longer.push_back(value.back());
    json reversed = value;
    std::reverse(reversed.begin(), reversed.end());
    mistakes.insert(mistakes.end(), {shorter, longer});
    if (reversed != value) mistakes.push_back(reversed);
  }
  return mistakes;
}

TEST_F(Program, AReportOnAPartThatWasChangedIsNotJoined) {
  ASSERT_EQ(run(kPaper).exitCode, 0);
  for (const std::string verb : {"measure cube.t4d --frames 4", "validate cube.t4d",
                                 "quality cube.t4d", "compress cube.t4d -o small.t4d",
                                 "rasterize cube.t4d --voxel-size 4 --frames 4 -o grids"}) {
    SCOPED_TRACE(verb);
    const std::string text = run(verb + " --json --part 1/2").out;
    write("1.json", text);
    write("2.json", run(verb + " --json --part 2/2").out);
    EXPECT_EQ(run("join 1.json 2.json").exitCode, 0);
    const json whole = json::parse(text);
    std::vector<Place> places;
    addPlaces(whole, Place(), places);
    for (const Place& place : places) {
      for (const json& mistake : mistakesOf(whole[place])) {
        json changed = whole;
        changed[place] = mistake;
        write("changed.json", changed.dump());
        const std::string path = place.to_string();
        const std::string name = path.substr(1, path.find('/', 1) - 1);
        // Other members of `part` may come first that must be equal in all parts.
        refuses("join changed.json 2.json",
                name == "part" ? ".json: " : "changed.json: '" + name + "'");
      }
    }
    for (const auto& [name, value] : whole.items()) {
      json without = whole;
      without.erase(name);
      write("changed.json", without.dump());
      refuses("join changed.json 2.json", name == "part"
                                              ? "changed.json: is not the report of a part"
                                              : "changed.json: '" + name + "'");
      json more = whole;
      more[name + "2"] = value;
      write("changed.json", more.dump());
      refuses("join changed.json 2.json", "changed.json: '" + name + "2'");
      write("changed.json", "{\"" + name + "\": 1, " + whole.dump().substr(1));
      refuses("join changed.json 2.json", name);
    }
  }
}

}  // namespace
}  // namespace t4d::tools
