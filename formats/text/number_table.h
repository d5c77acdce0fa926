#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/input_file.h"
#include "formats/text/text_scanner.h"
#include "t4d/error.h"

namespace t4d::formats {

/// Reads a table of numbers: a line with the names of the columns, and a line for each row. The
/// names may be in the last comment (`#`) before the first row, or missing. Columns are separated
/// by commas, semicolons, tabs or blanks. Where no commas separate them, numbers may have decimal
/// commas. The file must outlive the table.
class NumberTable {
 public:
  explicit NumberTable(const InputFile& file);

  /// Whether these are names of columns: asked of a comment before numbers, with the file's names.
  using AreNames = bool (*)(const std::vector<std::string>& names);

  /// Finds the names, and how numbers are written. Fails on commas that may be decimal or stand
  /// between thousands, and where both commas and points are decimal.
  Result<void> begin(AreNames areNames);

  /// The names of columns as they are written, without quotes and blanks around them; empty if the
  /// table has none.
  const std::vector<std::string>& names() const { return names_; }
  /// The fields of the first line with numbers, if the table has no names.
  std::size_t unnamedColumns() const { return unnamed_; }
  /// Names for a table that has none.
  void setNames(std::vector<std::string> names) { names_ = std::move(names); }
  bool separatedByBlanks() const { return separator_ == ' '; }

  /// Goes to the next row; false at the end.
  bool nextRow();
  /// The numbers of the row in these columns. Fails on a row with more or fewer fields than names,
  /// and on a field that is not a number; fields of other columns may be anything.
  Result<void> numbers(std::span<const std::size_t> columns, std::span<double> into);
  /// The text of a column in the row; empty if the row is too short.
  std::string_view text(std::size_t column) const {
    return column < fields_.size() ? fields_[column] : std::string_view();
  }
  std::uint64_t line() const { return line_; }
  Error invalidHere(std::string message) const {
    return invalid(std::move(message), file_.atLine(line_));
  }

  /// Unusual properties of the table, for a note, one phrase each.
  const std::vector<std::string>& form() const { return form_; }

 private:
  std::vector<std::string> namesInComment(std::size_t columns, AreNames areNames);
  bool areNumbers(const std::vector<std::string_view>& fields);
  Result<void> findDecimalComma();

  const InputFile& file_;
  TextScanner scanner_;
  char separator_ = ',';
  bool decimalComma_ = false;
  std::size_t unnamed_ = 0;
  std::optional<std::string_view> first_;  // row, if no line before it has the names
  std::vector<std::string_view> fields_;   // of the row
  std::uint64_t line_ = 0;
  std::vector<std::string> names_;
  std::vector<std::string> form_;
};

/// A phrase for a note about columns that are not read; the first of many.
std::string noticeOfUnread(std::vector<std::string> columns);

/// The name of a column without its unit, and the unit: "x" and "mm" of `x [mm]`, `x (mm)` and
/// `x_mm`. Units behind `_` are those of length, time and angle that are known.
struct ColumnName {
  std::string base;  ///< in lower case
  std::string unit;  ///< "" for none
};
ColumnName columnName(std::string_view name);

}  // namespace t4d::formats
