#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace t4d::tools {

/// A line of a text table: fields between commas, semicolons, tabs or spaces.
struct TableLine {
  std::uint64_t number = 0;  ///< in the file, from 1
  std::vector<std::string_view> fields = {};
};

/// The lines of a text table, without empty ones and those that begin with #.
class TableLines {
 public:
  /// `text` must outlive the lines.
  explicit TableLines(std::string_view text);

  /// The next line; nothing at the end.
  std::optional<TableLine> next();

 private:
  std::string_view rest_;
  std::uint64_t number_ = 0;
};

/// The beginning of a field, as an error shows it.
std::string_view quotable(std::string_view field);

}  // namespace t4d::tools
