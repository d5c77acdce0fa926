#include "formats/motion/joint_log.h"

#include <algorithm>
#include <cstdint>
#include <sstream>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "formats/text/json_check.h"
#include "formats/text/json_object.h"
#include "model/number.h"

namespace t4d::formats {
namespace {

using nlohmann::json;
using Fields = std::vector<std::string>;

bool isNumber(std::string_view text) { return model::numberIn<double>(text).has_value(); }

std::string trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\"'";
  const auto first = text.find_first_not_of(kBlanks);
  if (first == text.npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(kBlanks) - first + 1));
}

/// The fields of a line between commas that are in no quotes and no brackets.
Fields fieldsOf(std::string_view line) {
  Fields fields(1);
  int depth = 0;
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') quoted = !quoted;
    if (c == '[') ++depth;
    if (c == ']') --depth;
    if (c == ',' && !quoted && depth <= 0) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  for (std::string& field : fields) field = trimmed(field);
  return fields;
}

/// The elements of `[1, 2]`, also of `array('d', [1, 2])`; nothing of what has no brackets.
std::optional<Fields> arrayIn(const std::string& cell) {
  const auto open = cell.find('[');
  const auto close = cell.rfind(']');
  if (open == cell.npos || close == cell.npos || close < open) return std::nullopt;
  std::string inner = cell.substr(open + 1, close - open - 1);
  std::ranges::replace(inner, ',', ' ');
  std::istringstream words(inner);
  Fields elements;
  for (std::string word; words >> word;) elements.push_back(trimmed(word));
  return elements;
}

/// The messages of a log in JSON.
class Messages {
 public:
  explicit Messages(const InputFile& file) : file_(file) {}

  Result<std::optional<std::string>> table() {
    const std::string name = file_.path.string();
    try {
      if (auto good = checkJson(file_.bytes, name); !good) return good.error();
      if (const json whole = json::parse(file_.bytes, nullptr, false); !whole.is_discarded()) {
        collect(whole);
      } else {
        std::istringstream lines(file_.bytes);
        for (std::string line; std::getline(lines, line);) {
          if (auto good = checkJson(line, name); !good) return good.error();
          if (!trimmed(line).empty()) collect(json::parse(line));
        }
      }
      if (trajectories_ > 1) {
        return invalid(fmt::format("has {} trajectories, expected one", trajectories_), name);
      }
      if (chosen().joints.empty()) {
        return invalid(
            "is JSON without joints: expected joint_names and points, or states with "
            "name and position",
            name);
      }
    } catch (const json::exception& error) {
      return invalid("is not a log of joints in JSON: " + jsonMessage(error), name);
    }
    if (chosen().changed) {
      return invalid("has states of different joints; keep those of one robot", name);
    }
    return fmt::format("time_s,{}\n{}", fmt::join(chosen().joints, ","), chosen().rows);
  }

 private:
  struct Rows {
    Fields joints;
    std::string rows;
    bool changed = false;
  };

  /// A state beside a trajectory is where that begins.
  const Rows& chosen() const { return trajectories_ > 0 ? trajectory_ : states_; }

  void collect(const json& value) {
    if (value.is_array()) {
      for (const json& one : value) collect(one);
    }
    if (!value.is_object()) return;
    if (value.contains("joint_names") && value.contains("points")) return addTrajectory(value);
    if (value.contains("name") && value.contains("position") && value["name"].is_array()) {
      const json& header = value.contains("header") ? value["header"] : value;
      return addRow(value["name"], header.at("stamp"), value["position"], states_);
    }
    for (const json& one : value) collect(one);
  }

  /// Those of a robot are there for joints with one value and for those with poses, or empty.
  void addTrajectory(const json& trajectory) {
    if (trajectory["points"].empty()) return;
    ++trajectories_;
    for (const json& point : trajectory["points"]) {
      const json& time = point.at("time_from_start");
      if (point.contains("transforms")) {
        addPoses(trajectory["joint_names"], time, point["transforms"]);
      } else {
        addRow(trajectory["joint_names"], time, point.at("positions"), trajectory_);
      }
    }
  }

  void addPoses(const json& names, const json& time, const json& transforms) {
    json columns = json::array();
    json values = json::array();
    for (const json& name : names) {
      for (const char* part : {".x", ".y", ".z", ".qx", ".qy", ".qz", ".qw"}) {
        columns.push_back(name.get<std::string>() + part);
      }
    }
    for (const json& transform : transforms) {
      for (const char* axis : {"x", "y", "z"}) {
        values.push_back(transform.at("translation").at(axis));
      }
      for (const char* axis : {"x", "y", "z", "w"}) {
        values.push_back(transform.at("rotation").at(axis));
      }
    }
    addRow(columns, time, values, trajectory_);
  }

  static void addRow(const json& names, const json& time, const json& positions, Rows& into) {
    const Fields joints = names.get<Fields>();
    if (into.joints.empty()) into.joints = joints;
    into.changed = into.changed || joints != into.joints || positions.size() != joints.size();
    into.rows += fmt::format("{},{}\n", secondsOf(time),
                             fmt::join(positions.get<std::vector<double>>(), ","));
  }

  /// The seconds of a stamp or a duration, as ROS 1 and ROS 2 write them.
  static double secondsOf(const json& time) {
    if (time.is_number()) return time.get<double>();
    constexpr double kNanosecond = 1e-9;
    const auto part = [&](const char* name, const char* other) {
      return time.contains(name) ? time[name].get<double>() : time.value(other, 0.0);
    };
    return part("sec", "secs") + part("nanosec", "nsecs") * kNanosecond;
  }

  const InputFile& file_;
  Rows trajectory_;
  Rows states_;
  std::size_t trajectories_ = 0;
};

/// How many names of joints there are in a line of `ros2 topic echo --csv`, behind the stamp and
/// the name of the frame; 0 of another line.
std::size_t namesIn(const Fields& fields) {
  constexpr std::size_t kFirst = 3;
  if (fields.size() < kFirst + 2 || !isNumber(fields[0]) || !isNumber(fields[1])) return 0;
  std::size_t end = kFirst;
  while (end < fields.size() && !fields[end].empty() && !isNumber(fields[end])) ++end;
  const std::size_t names = end - kFirst;
  return end + names <= fields.size() ? names : 0;
}

Result<std::optional<std::string>> tableOfEcho(const InputFile& file, std::size_t names) {
  constexpr std::size_t kFirst = 3;
  std::istringstream lines(file.bytes);
  std::string table;
  Fields joints;
  std::uint64_t number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    const Fields fields = fieldsOf(line);
    if (fields.size() == 1 && fields[0].empty()) continue;
    if (namesIn(fields) != names)
      return invalid("names other joints than the first line", file.atLine(number));
    const auto begin = fields.begin() + kFirst;
    const auto end = begin + static_cast<std::ptrdiff_t>(names);
    if (joints.empty()) {
      joints.assign(begin, end);
      table = fmt::format("sec,nanosec,{}\n", fmt::join(joints, ","));
    }
    if (!std::equal(begin, end, joints.begin())) {
      return invalid("names other joints than the first line", file.atLine(number));
    }
    table +=
        fmt::format("{},{},{}\n", fields[0], fields[1], fmt::join(end, end + (end - begin), ","));
  }
  return table;
}

/// A table whose first row has arrays; nothing without.
class ArrayTable {
 public:
  explicit ArrayTable(const InputFile& file) : file_(file) {}

  Result<std::optional<std::string>> table() {
    std::istringstream lines(file_.bytes);
    std::string line;
    std::getline(lines, line);
    const Fields names = fieldsOf(line);
    std::string made;
    for (std::uint64_t number = 2; std::getline(lines, line); ++number) {
      const Fields fields = fieldsOf(line);
      if (made.empty()) {
        if (fields.size() != names.size() || !findArrays(names, fields)) return std::nullopt;
        made = fmt::format("{}\n", fmt::join(header_, ","));
      }
      const auto row = rowOf(fields);
      if (!row) {
        return invalid("has other arrays than the first row, or joints in another order",
                       file_.atLine(number));
      }
      made += fmt::format("{}\n", fmt::join(*row, ","));
    }
    return made;
  }

 private:
  bool findArrays(const Fields& names, const Fields& first) {
    bool any = false;
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (names[i] == "name") joints_ = arrayIn(first[i]).value_or(Fields());
    }
    for (std::size_t i = 0; i < names.size(); ++i) {
      const auto array = arrayIn(first[i]);
      any = any || array;
      lengths_.push_back(array ? array->size() : 0);
      const bool ofJoints = !joints_.empty();
      const bool kept = !array || (ofJoints ? names[i] == "position" : true);
      kept_.push_back(kept);
      isName_.push_back(names[i] == "name" && ofJoints);
      if (!kept) continue;
      if (!array) header_.push_back(names[i]);
      for (std::size_t k = 0; k < lengths_.back(); ++k) {
        const bool named = lengths_.back() == joints_.size();
        header_.push_back(named ? joints_[k] : fmt::format("{}_{}", names[i], k));
      }
    }
    return any;
  }

  std::optional<Fields> rowOf(const Fields& fields) const {
    if (fields.size() != kept_.size()) return std::nullopt;
    Fields row;
    for (std::size_t i = 0; i < fields.size(); ++i) {
      const auto array = arrayIn(fields[i]);
      if (isName_[i] && array != joints_) return std::nullopt;
      if (!kept_[i]) continue;
      if ((array ? array->size() : 0) != lengths_[i]) return std::nullopt;
      if (array) {
        row.insert(row.end(), array->begin(), array->end());
      } else {
        row.push_back(fields[i]);
      }
    }
    return row;
  }

  const InputFile& file_;
  Fields joints_;
  Fields header_;
  std::vector<std::size_t> lengths_;  // of the arrays, by column
  std::vector<bool> kept_;
  std::vector<bool> isName_;
};

}  // namespace

Result<std::optional<std::string>> tableOfLog(const InputFile& file) {
  const auto first = file.bytes.find_first_not_of(" \t\r\n");
  if (first == file.bytes.npos) return std::nullopt;
  const std::string_view rest = std::string_view(file.bytes).substr(first);
  const std::string_view line = rest.substr(0, rest.find('\n'));
  const bool isJson = line[0] == '{' || (line[0] == '[' && !isNumber(trimmed(line.substr(1))));
  if (isJson) return Messages(file).table();
  if (const std::size_t names = namesIn(fieldsOf(line)); names > 0) return tableOfEcho(file, names);
  if (rest.find('[', line.size()) == rest.npos) return std::nullopt;
  return ArrayTable(file).table();
}

}  // namespace t4d::formats
