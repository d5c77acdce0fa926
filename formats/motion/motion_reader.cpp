#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "formats/file_extension.h"
#include "formats/input_file.h"
#include "formats/motion/motion_csv.h"
#include "formats/motion/motion_formats.h"
#include "formats/text/json_check.h"
#include "formats/text/json_object.h"
#include "t4d/motion.h"

namespace t4d::formats {
namespace {

using nlohmann::json;

model::ScrewRun screwRun(const json& value, Place where) {
  const JsonObject segment(
      value, std::move(where),
      {"duration", "axis_point", "axis_direction", "angle_degrees", "translation", "repeat"});
  model::ScrewRun run;
  segment.need("duration");
  run.duration = segment.number("duration", 0);
  run.screw.axisPoint = segment.numbers<3>("axis_point", model::Point3::Zero());
  run.screw.angleDegrees = segment.number("angle_degrees", 0);
  if (run.screw.angleDegrees != 0) segment.need("axis_direction");
  run.screw.axisDirection = segment.numbers<3>("axis_direction", Eigen::Vector3d::UnitZ());
  run.screw.translation = segment.numbers<3>("translation", Eigen::Vector3d::Zero());
  run.count = segment.count("repeat", 1);
  return run;
}

model::KeyPose keyPose(const json& value, Place where) {
  const JsonObject pose(value, std::move(where), {"time", "position", "quaternion"});
  model::KeyPose key;
  pose.need("time");
  key.time = pose.number("time", 0);
  key.position = pose.numbers<3>("position", model::Point3::Zero());
  const Eigen::Vector4d q = pose.numbers<4>("quaternion", Eigen::Vector4d::UnitW());
  key.quaternion = Eigen::Quaterniond(q[3], q[0], q[1], q[2]);  // w first
  return key;
}

Result<model::Motion> motionOf(const json& value, const Place& name) {
  const JsonObject file(value, placeIn(name, "motion"),
                        {"$schema", "length_unit", "time_unit", "start_time", "segments", "poses"});
  Result<model::Motion> motion;
  if (file.has("poses")) {
    for (const char* other : {"segments", "start_time"}) {
      if (file.has(other)) {
        refuseJson(fmt::format("has both 'poses' and '{}'; poses carry their own times", other),
                   file.where());
      }
    }
    std::vector<model::KeyPose> poses;
    for (const json& pose : file.array("poses")) {
      poses.push_back(
          keyPose(pose, jsonPlace(file.where("poses"), fmt::format("[{}]", poses.size()))));
    }
    motion = joinPoses(poses);
  } else {
    if (!file.has("segments")) refuseJson("lacks the key 'segments' or 'poses'", file.where());
    std::vector<model::ScrewRun> runs;
    for (const json& segment : file.array("segments")) {
      runs.push_back(
          screwRun(segment, jsonPlace(file.where("segments"), fmt::format("[{}]", runs.size()))));
    }
    motion = chainScrews(file.number("start_time", 0), runs);
  }
  if (!motion) {
    return invalid(motion.error().text(), name);
  }
  for (model::HalfTurn& turn : motion->halfTurns) {
    turn.between = fmt::format("poses[{}] and poses[{}]", turn.pose, turn.pose + 1);
  }
  motion->lengthUnit = file.text("length_unit");
  motion->timeUnit = file.text("time_unit");
  return motion;
}

}  // namespace

Result<model::Motion> parseMotion(const std::string& text, const Place& name) try {
  // The parser would keep the last value of a key that comes twice.
  if (auto good = checkJson(text, name); !good) return good.error();
  return motionOf(json::parse(text), name);
} catch (const JsonRefusal& refusal) {
  return refusal.error;
} catch (const json::exception& error) {
  return invalid("is not JSON: " + jsonMessage(error), name);
}

std::vector<platform::FileFormat> motionFormats() {
  return {{"t4d motion", {".json"}, {"screw motions", "units"}},
          {"table of poses", {".csv", ".tsv", ".txt"}, {"screw motions"}}};
}

Result<model::Motion> readMotion(const std::filesystem::path& path, std::string* form,
                                 const MotionTableOptions& table) {
  const std::string extension = lowerCaseExtension(path);
  if (extension == ".bvh") {
    return fail(ErrorCode::Unsupported,
                "is the motion of a skeleton (BVH), expected that of one rigid solid: export the "
                "poses of a joint as a table (.csv)",
                path.string());
  }
  auto file = readInputFile(path);
  if (!file) return file.error();
  if (extension != ".json" && isOneOf(motionFormats(), path)) {
    return readMotionCsv(*file, form, table);
  }
  if (!table.empty()) {
    return fail(ErrorCode::Options,
                "is JSON, which names its units and the kind of its rotations itself; these are "
                "stated for tables only",
                path.string());
  }
  return parseMotion(file->bytes, path.string());
}

}  // namespace t4d::formats
