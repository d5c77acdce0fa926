#include "t4d/formats/motion_reader.h"

#include <algorithm>
#include <initializer_list>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "t4d/formats/file_extension.h"
#include "t4d/formats/input_file.h"
#include "t4d/formats/json_check.h"
#include "t4d/formats/motion_csv.h"

namespace t4d::formats {
namespace {

using nlohmann::json;

/// Ends parsing; caught at the end of parseMotion.
struct Refusal {
  Error error;
};

[[noreturn]] void refuse(std::string message, std::string where) {
  throw Refusal{Error{ErrorCode::InvalidInput, std::move(message), std::move(where)}};
}

/// A JSON object with the keys it may have, read one by one.
class Object {
 public:
  Object(const json& value, std::string where, std::initializer_list<std::string_view> known)
      : value_(value), where_(std::move(where)) {
    if (!value.is_object()) {
      refuse(fmt::format("is {}, where an object is expected", describe(value)), where_);
    }
    for (const auto& [key, unused] : value.items()) {
      if (std::find(known.begin(), known.end(), key) == known.end()) {
        refuse(fmt::format("has the unknown key '{}'; known are {}", key, fmt::join(known, ", ")),
               where_);
      }
    }
  }

  bool has(const char* key) const { return value_.contains(key); }
  const std::string& where() const { return where_; }
  std::string where(const char* key) const { return where_ + "." + key; }

  const json& need(const char* key) const {
    const auto found = value_.find(key);
    if (found == value_.end()) refuse(fmt::format("lacks the key '{}'", key), where_);
    return *found;
  }
  double number(const char* key, double otherwise) const {
    return has(key) ? numberOf(need(key), where(key)) : otherwise;
  }
  std::string text(const char* key) const {
    if (!has(key)) return {};
    const json& value = need(key);
    if (!value.is_string()) {
      refuse(fmt::format("is {}, where text is expected", describe(value)), where(key));
    }
    return value.get<std::string>();
  }
  std::uint64_t count(const char* key, std::uint64_t otherwise) const {
    if (!has(key)) return otherwise;
    const json& value = need(key);
    if (!value.is_number_unsigned()) {
      refuse(fmt::format("is {}, where a whole number from 1 on is expected", describe(value)),
             where(key));
    }
    return value.get<std::uint64_t>();
  }
  template <int Size>
  Eigen::Matrix<double, Size, 1> numbers(const char* key,
                                         const Eigen::Matrix<double, Size, 1>& otherwise) const {
    if (!has(key)) return otherwise;
    const json& value = need(key);
    if (!value.is_array() || value.size() != Size) {
      refuse(fmt::format("is {}, where an array of {} numbers is expected", describe(value), Size),
             where(key));
    }
    Eigen::Matrix<double, Size, 1> result;
    for (int i = 0; i < Size; ++i) {
      result[i] =
          numberOf(value[static_cast<std::size_t>(i)], fmt::format("{}[{}]", where(key), i));
    }
    return result;
  }
  const json& array(const char* key) const {
    const json& value = need(key);
    if (!value.is_array()) {
      refuse(fmt::format("is {}, where an array is expected", describe(value)), where(key));
    }
    return value;
  }

 private:
  /// Scalars as written; only the kind of arrays and objects, which may be deep.
  static std::string describe(const json& value) {
    if (value.is_array()) return fmt::format("an array of {} values", value.size());
    if (value.is_object()) return "an object";
    constexpr std::size_t kShown = 40;
    const std::string text = value.dump(-1, ' ', false, json::error_handler_t::replace);
    return text.size() > kShown ? text.substr(0, kShown) + "..." : text;
  }
  static double numberOf(const json& value, const std::string& where) {
    if (!value.is_number()) {
      refuse(fmt::format("is {}, where a number is expected", describe(value)), where);
    }
    return value.get<double>();
  }

  const json& value_;
  std::string where_;
};

model::ScrewRun screwRun(const json& value, const std::string& where) {
  const Object segment(
      value, where,
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

model::KeyPose keyPose(const json& value, const std::string& where) {
  const Object pose(value, where, {"time", "position", "quaternion"});
  model::KeyPose key;
  pose.need("time");
  key.time = pose.number("time", 0);
  key.position = pose.numbers<3>("position", model::Point3::Zero());
  const Eigen::Vector4d q = pose.numbers<4>("quaternion", Eigen::Vector4d::UnitW());
  key.quaternion = Eigen::Quaterniond(q[3], q[0], q[1], q[2]);  // w first
  return key;
}

Result<model::Motion> motionOf(const json& value, const std::string& name) {
  const Object file(value, name + ": motion",
                    {"$schema", "length_unit", "time_unit", "start_time", "segments", "poses"});
  Result<model::Motion> motion;
  if (file.has("poses")) {
    for (const char* other : {"segments", "start_time"}) {
      if (file.has(other)) {
        refuse(fmt::format("has both 'poses' and '{}'; poses carry their own times", other),
               file.where());
      }
    }
    std::vector<model::KeyPose> poses;
    for (const json& pose : file.array("poses")) {
      poses.push_back(keyPose(pose, fmt::format("{}.poses[{}]", file.where(), poses.size())));
    }
    motion = joinPoses(poses);
  } else {
    if (!file.has("segments")) refuse("lacks the key 'segments' or 'poses'", file.where());
    std::vector<model::ScrewRun> runs;
    for (const json& segment : file.array("segments")) {
      runs.push_back(screwRun(segment, fmt::format("{}.segments[{}]", file.where(), runs.size())));
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

Result<model::Motion> parseMotion(const std::string& text, const std::string& name) try {
  // Of a key that comes twice the parser would keep the last value.
  if (auto good = checkJson(text, name); !good) return pass(good.error());
  return motionOf(json::parse(text), name);
} catch (const Refusal& refusal) {
  return pass(refusal.error);
} catch (const json::exception& error) {
  // "[json.exception.parse_error.101] parse error at line 3, column 5: ..."
  const std::string_view what = error.what();
  const auto text1 = what.find("] ");
  return invalid(fmt::format("is not JSON: {}",
                             text1 == std::string_view::npos ? what : what.substr(text1 + 2)),
                 name);
}

Result<model::Motion> readMotion(const std::filesystem::path& path, std::string* form) {
  const std::string extension = lowerCaseExtension(path);
  if (extension == ".bvh") {
    return fail(ErrorCode::Unsupported,
                "is the motion of a skeleton (BVH), expected that of one rigid solid: export the "
                "poses of a joint as a table (.csv)",
                path.string());
  }
  auto file = readInputFile(path);
  if (!file) return pass(file.error());
  if (extension == ".csv" || extension == ".tsv" || extension == ".txt") {
    return readMotionCsv(*file, form);
  }
  return parseMotion(file->bytes, path.string());
}

}  // namespace t4d::formats
