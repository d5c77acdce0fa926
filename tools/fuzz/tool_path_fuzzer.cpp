#include <cmath>
#include <string>

#include "formats/toolpath/cutter_location_reader.h"
#include "formats/toolpath/gcode_reader.h"
#include "tools/fuzz/fuzz.h"

/// Paths of tools, cutter locations if the first byte is a letter that their statements begin with
/// and G-code otherwise, on a mill of three axes or, after a #, on one of five with a tool table
/// and places: an accepted path has no gaps and only finite numbers.
namespace t4d::fuzz {
namespace {

int test(std::span<const std::uint8_t> bytes) {
  const formats::InputFile file{"path", std::string(bytes.begin(), bytes.end())};
  // Arcs of many chords and long loops are allowed but slow.
  formats::ToolPathOptions coarse{.tolerance = 1e3, .repeatedLines = 3000};
  if (file.bytes.starts_with("#")) {
    coarse.tools = {1, 2};
    coarse.lengths = {{1, {0, 0, 10}}, {2, {1, -2, 30}}};
    coarse.offsets = {{530, {0, 0, 100}}, {550, {10, 0, 0}}, {280, {1, 2, -3}}};
    coarse.rotaries = {
        {3, true, 1, {0, 0, -50}}, {5, true, -1, {1, 0, 0}}, {4, false, 1, {0, 0, 90}}};
  }
  const bool locations = file.bytes.starts_with("P") || file.bytes.starts_with("F") ||
                         file.bytes.starts_with("GOTO") || file.bytes.starts_with("UNITS");
  const auto path =
      locations ? formats::readCutterLocations(file, coarse) : formats::readGcode(file, coarse);
  if (!path) {
    must(!path.error().message.empty() && path.error().where.file.starts_with("path"),
         "a refusal says what and where");
    return 0;
  }
  const auto& segments = path->motion.segments;
  must(!segments.empty(), "a path moves");
  for (std::size_t i = 0; i < segments.size(); ++i) {
    must(segments[i].timeBegin < segments[i].timeEnd && std::isfinite(segments[i].timeEnd),
         "a move lasts");
    for (const double fraction : {0.0, 0.3, 1.0}) {
      const model::Pose pose = segments[i].at(fraction);
      must(pose.rotation.allFinite() && pose.translation.allFinite(), "poses are finite");
      must((pose.rotation * pose.rotation.transpose()).isIdentity(1e-9), "poses are rigid");
    }
    if (i == 0) continue;
    must(segments[i - 1].timeEnd == segments[i].timeBegin &&
             segments[i - 1].end.translation == segments[i].start.translation,
         "a move begins where the one before ends");
  }
  for (std::size_t i = 0; i < path->mountings.size(); ++i) {
    must(path->mountings[i].time <= path->motion.timeEnd() &&
             (i == 0 || path->mountings[i - 1].time < path->mountings[i].time),
         "tools are mounted in order");
  }
  for (const model::TimeSpan& rapid : path->rapids) {
    must(rapid.begin < rapid.end && rapid.end <= path->motion.timeEnd(), "rapids are in the path");
  }
  return 0;
}

}  // namespace
}  // namespace t4d::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return t4d::fuzz::test({data, size});
}
