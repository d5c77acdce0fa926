#include "formats/motion/joint_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "formats/motion/joint_log.h"
#include "formats/motion/time_column.h"
#include "formats/text/number_table.h"

namespace t4d::formats {
namespace {

bool hasTime(const std::vector<std::string>& names) {
  return std::ranges::any_of(names, &TimeColumn::isTime);
}

/// `field.position3` for "position": the number behind the word at the end of a name.
std::optional<int> numberBehind(std::string_view name, std::string_view word) {
  const auto at = name.rfind(word);
  if (at == name.npos || (at > 0 && name[at - 1] != '.' && name[at - 1] != '/')) return {};
  std::string_view digits = name.substr(at + word.size());
  if (digits.starts_with('_')) digits.remove_prefix(1);
  if (digits.empty() || digits.size() > 3) return std::nullopt;
  int number = 0;
  for (const char digit : digits) {
    if (digit < '0' || digit > '9') return std::nullopt;
    number = 10 * number + (digit - '0');
  }
  return number;
}

/// The joint of `/joint_states/shoulder/position`; nothing of another qualified name.
std::optional<std::string> jointOf(std::string_view name) {
  const auto last = name.find_last_of("./");
  if (last == name.npos) return std::string(name);
  if (name.substr(last + 1) != "position") return std::nullopt;
  const auto before = name.substr(0, last).find_last_of("./");
  return std::string(name.substr(before + 1, last - before - 1));
}

class JointTableReader {
 public:
  JointTableReader(const InputFile& file, const std::string& timeUnit,
                   const std::set<std::string>& joints)
      : file_(file), timeUnit_(timeUnit), joints_(joints), table_(file) {}

  Result<JointTable> read() {
    if (auto begun = table_.begin(hasTime); !begun) return begun.error();
    if (table_.unnamedColumns() > 0) {
      return table_.invalidHere(fmt::format(
          "found {} numbers, expected a first line with the names of the columns: the time ({}) "
          "and joints",
          table_.unnamedColumns(), kTimeColumns));
    }
    if (auto found = findColumns(); !found) return found.error();
    while (table_.nextRow()) {
      if (auto added = addRow(); !added) return added.error();
    }
    made_.times = rows_.times();
    if (made_.times.size() < 2) {
      return invalid(fmt::format("has {} row{} of values; at least two are needed",
                                 made_.times.size(), made_.times.size() == 1 ? "" : "s"),
                     file_.path.string());
    }
    made_.timeUnit = time_.unit();
    addNotices();
    return std::move(made_);
  }

 private:
  Result<void> findColumns() {
    const std::vector<std::string>& names = table_.names();
    time_ = TimeColumn::find(names);
    if (time_.empty()) {
      return table_.invalidHere(
          fmt::format("the column of the time is missing ({}); the columns are {}", kTimeColumns,
                      fmt::join(names, ", ")));
    }
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (numberBehind(names[i], "name")) nameColumns_.push_back(i);
    }
    std::set<std::string> joints;
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (std::ranges::find(time_.columns(), i) != time_.columns().end()) continue;
      if (auto added = addColumn(i, joints); !added) return added;
    }
    if (!columns_.empty()) return {};
    return table_.invalidHere(
        fmt::format("no column is a joint; the columns are {}", fmt::join(names, ", ")));
  }

  Result<void> addColumn(std::size_t column, std::set<std::string>& joints) {
    const std::string& name = table_.names()[column];
    std::optional<std::string> joint;
    std::optional<std::size_t> namedBy;
    std::string unitless;
    std::string unit;
    if (nameColumns_.empty()) {
      if (!TimeColumn::isTime(name)) joint = isJoint(name) ? name : jointOf(name);
      const ColumnName parts = columnName(joint.value_or(""));
      // Names of joints keep their case.
      unitless = joint.value_or("").substr(0, parts.base.size());
      unit = parts.unit;
    } else if (const auto number = numberBehind(name, "position")) {
      for (const std::size_t i : nameColumns_) {
        if (numberBehind(table_.names()[i], "name") == number) namedBy = i;
      }
      if (namedBy) joint = std::string();  // known with the first row
    }
    if (!joint) {
      const bool isName = std::ranges::find(nameColumns_, column) != nameColumns_.end();
      if (!isName) skipped_.push_back(name);
      return {};
    }
    if (!namedBy && !joints.insert(*joint).second) {
      return table_.invalidHere(
          fmt::format("two columns are the joint {}; keep one of them", inQuotes(*joint)));
    }
    columns_.push_back(column);
    namedBy_.push_back(namedBy);
    made_.columns.push_back({*joint, unitless, unit, {}});
    return {};
  }

  /// Whether a column is a joint that is asked for, with or without its unit.
  bool isJoint(const std::string& name) const {
    return joints_.contains(name) || joints_.contains(name.substr(0, columnName(name).base.size()));
  }

  Result<void> addRow() {
    std::array<double, 2> stamps{};
    const auto stamp = std::span(stamps).first(time_.columns().size());
    if (auto read = table_.numbers(time_.columns(), stamp); !read) return read;
    if (auto named = checkNames(); !named) return named;
    std::vector<double> values(columns_.size());
    if (auto read = table_.numbers(columns_, values); !read) return read;
    if (rows_.times().empty()) {
      if (auto chosen = time_.choose(stamp, timeUnit_); !chosen) {
        return table_.invalidHere(chosen.error().message);
      }
    }
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (std::isfinite(values[i])) continue;
      return table_.invalidHere(fmt::format("column {}: found {}, expected a finite number",
                                            table_.names()[columns_[i]], values[i]));
    }
    const auto added = rows_.add(table_, time_.at(stamp), values);
    if (!added) return added.error();
    if (!*added) return {};
    for (std::size_t i = 0; i < values.size(); ++i) made_.columns[i].values.push_back(values[i]);
    return {};
  }

  /// The names of joints in a message of ROS are those of the first row.
  Result<void> checkNames() {
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (!namedBy_[i]) continue;
      const std::string name(table_.text(*namedBy_[i]));
      std::string& joint = made_.columns[i].name;
      if (rows_.times().empty() && joint.empty()) joint = name;
      if (joint == name && !name.empty()) continue;
      return table_.invalidHere(fmt::format(
          "column {}: found {}, expected the joint {} of the first row: write a column for each "
          "joint",
          table_.names()[*namedBy_[i]], inQuotes(name), inQuotes(joint)));
    }
    return {};
  }

  void addNotices() {
    made_.notices = table_.form();
    if (!skipped_.empty()) made_.notices.push_back(noticeOfUnread(skipped_));
    if (auto notice = rows_.notice(); !notice.empty()) made_.notices.push_back(notice);
  }

  const InputFile& file_;
  const std::string& timeUnit_;
  const std::set<std::string>& joints_;
  NumberTable table_;
  TimeColumn time_;
  std::vector<std::size_t> nameColumns_;
  std::vector<std::size_t> columns_;                 // of joints
  std::vector<std::optional<std::size_t>> namedBy_;  // the column with the joint's name
  std::vector<std::string> skipped_;
  RowTimes rows_;
  JointTable made_;
};

}  // namespace

JointTable::Found JointTable::find(const std::string& joint) const {
  for (const Column& column : columns) {
    if (column.name == joint) return {&column};
  }
  for (const Column& column : columns) {
    if (column.unitless == joint) return {&column, column.unit};
  }
  return {};
}

Result<JointTable> readJointTable(const InputFile& file, const std::string& timeUnit,
                                  const std::set<std::string>& joints) {
  auto log = tableOfLog(file);
  if (!log) return log.error();
  if (!*log) return JointTableReader(file, timeUnit, joints).read();
  const InputFile table{file.path, std::move(**log)};
  return JointTableReader(table, timeUnit, joints).read();
}

}  // namespace t4d::formats
