#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "formats/text/number_table.h"
#include "model/units.h"
#include "t4d/error.h"

namespace t4d::formats {

/// The columns of a table that hold the time: `time`, `t` or `timestamp`, with or without a unit;
/// `__time`; `%time`, as ROS prints it; or `secs` and `nsecs`, or `sec` and `nanosec`, also as the
/// last part of a name such as `header.stamp.secs`.
class TimeColumn {
 public:
  /// Empty if none of the names is a time. A whole time comes before seconds and nanoseconds.
  static TimeColumn find(std::span<const std::string> names);

  bool empty() const { return columns_.empty(); }
  std::span<const std::size_t> columns() const { return columns_; }
  /// Whether a name is that of a time, be it used or not.
  static bool isTime(std::string_view name);

  /// `first` has the numbers of the first row, one for each of columns(); `wanted` is the unit that
  /// times are to have, "" for that of the column, or seconds if that is nanoseconds. Fails for a
  /// unit that is not one of time.
  Result<void> choose(std::span<const double> first, const std::string& wanted);
  /// The unit of the times, after choose(); "" if unknown.
  const std::string& unit() const { return unit_; }
  double at(std::span<const double> numbers) const;

 private:
  std::vector<std::size_t> columns_;  // one, or seconds and nanoseconds
  std::string name_;                  // of the first
  std::string stated_;                // the unit that the name states
  std::string unit_;
  model::UnitConversion conversion_;
};

/// The times of the rows of a table, which increase.
class RowTimes {
 public:
  /// Adds the time of the table's row, and returns true; false for a row with the same time and
  /// `content` as the row before, which is to be left out. Fails, with the line, on other times
  /// that do not increase, and on those that are not finite.
  Result<bool> add(const NumberTable& table, double time, std::span<const double> content);

  const std::vector<double>& times() const { return times_; }
  const std::vector<std::uint64_t>& lines() const { return lines_; }  ///< one for each time
  /// The rows that were left out, for a note; "" for none.
  std::string notice() const;

 private:
  std::vector<double> times_;
  std::vector<std::uint64_t> lines_;
  std::vector<double> last_;  // content
  std::size_t repeated_ = 0;
  std::uint64_t firstRepeated_ = 0;
};

/// The names of columns of times, for messages.
inline constexpr const char* kTimeColumns =
    "time, t or timestamp, also with a unit as time_ms or time [ms], or secs and nsecs";

}  // namespace t4d::formats
