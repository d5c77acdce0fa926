#include "formats/motion/time_column.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

namespace t4d::formats {
namespace {

constexpr double kNanosecondsPerSecond = 1e9;
/// ROS prints `%time` in nanoseconds since 1970. Smaller numbers are another program's.
constexpr double kLeastRosTime = 1e15;
constexpr const char* kRosTime = "%time";

enum class Kind { None, Whole, Seconds, Nanoseconds };

Kind kindOf(const std::string& base) {
  for (const char* name : {"time", "t", "timestamp", "__time", kRosTime}) {
    if (base == name) return Kind::Whole;
  }
  const std::string last = base.substr(base.find_last_of("./") + 1);
  if (last == "secs" || last == "sec") return Kind::Seconds;
  if (last == "nsecs" || last == "nsec" || last == "nanosec") return Kind::Nanoseconds;
  return Kind::None;
}

}  // namespace

bool TimeColumn::isTime(std::string_view name) {
  return kindOf(columnName(name).base) != Kind::None;
}

TimeColumn TimeColumn::find(std::span<const std::string> names) {
  TimeColumn found;
  std::optional<std::size_t> seconds;
  std::optional<std::size_t> nanoseconds;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const ColumnName name = columnName(names[i]);
    const Kind kind = kindOf(name.base);
    if (kind == Kind::Whole && found.empty()) {
      found.columns_ = {i};
      found.name_ = names[i];
      found.stated_ = name.unit;
    }
    if (kind == Kind::Seconds && !seconds) seconds = i;
    if (kind == Kind::Nanoseconds && !nanoseconds) nanoseconds = i;
  }
  if (found.empty() && seconds) {
    found.columns_ = {*seconds};
    if (nanoseconds) found.columns_.push_back(*nanoseconds);
    found.name_ = names[*seconds];
    found.stated_ = "s";
  }
  return found;
}

Result<void> TimeColumn::choose(std::span<const double> first, const std::string& wanted) {
  std::string stated = stated_;
  const bool isRosTime = columnName(name_).base == kRosTime && first[0] >= kLeastRosTime;
  if (stated.empty() && isRosTime) stated = "ns";
  // Nanoseconds since 1970 have more digits than a double.
  unit_ = !wanted.empty() ? wanted : stated == "ns" ? "s" : stated;
  if (stated.empty()) return {};
  const auto conversion = model::timeConversion(stated, unit_);
  if (!conversion) {
    return invalid(
        fmt::format("the column '{}' is in '{}', which cannot be converted to '{}'; "
                    "known units of time are ns, us, ms, s, min, h and d",
                    name_, stated, unit_));
  }
  conversion_ = *conversion;
  return {};
}

double TimeColumn::at(std::span<const double> numbers) const {
  const double whole =
      numbers.size() == 2 ? numbers[0] + numbers[1] / kNanosecondsPerSecond : numbers[0];
  return conversion_(whole);
}

Result<bool> RowTimes::add(const NumberTable& table, double time, std::span<const double> content) {
  if (!std::isfinite(time)) return table.invalidHere("the time is not finite");
  if (times_.empty() || time > times_.back()) {
    times_.push_back(time);
    lines_.push_back(table.line());
    last_.assign(content.begin(), content.end());
    return true;
  }
  if (time < times_.back()) {
    return table.invalidHere(
        fmt::format("is at time {}, not after line {}, at {}: times must increase; sort the lines "
                    "by time",
                    time, lines_.back(), times_.back()));
  }
  if (!std::ranges::equal(content, last_)) {
    return table.invalidHere(fmt::format(
        "is at time {}, as line {}, with other values: keep one of the two", time, lines_.back()));
  }
  if (repeated_++ == 0) firstRepeated_ = table.line();
  return false;
}

std::string RowTimes::notice() const {
  if (repeated_ == 0) return {};
  if (repeated_ == 1) {
    return fmt::format("line {} repeats the one before and is left out", firstRepeated_);
  }
  return fmt::format("{} lines repeat the one before and are left out, the first line {}",
                     repeated_, firstRepeated_);
}

}  // namespace t4d::formats
