#include "tools/t4d/text_table.h"

#include <algorithm>

namespace t4d::tools {
namespace {

std::vector<std::string_view> fieldsOf(std::string_view line) {
  constexpr std::string_view kSeparators = ",; \t\r";
  std::vector<std::string_view> fields;
  while (true) {
    line.remove_prefix(std::min(line.find_first_not_of(kSeparators), line.size()));
    if (line.empty()) return fields;
    const std::size_t end = std::min(line.find_first_of(kSeparators), line.size());
    fields.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

}  // namespace

TableLines::TableLines(std::string_view text) : rest_(text) {
  if (rest_.starts_with("\xEF\xBB\xBF")) rest_.remove_prefix(3);
}

std::optional<TableLine> TableLines::next() {
  while (!rest_.empty()) {
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    TableLine line{++number_, fieldsOf(rest_.substr(0, end))};
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    if (!line.fields.empty() && !line.fields.front().starts_with('#')) return line;
  }
  return std::nullopt;
}

std::string_view quotable(std::string_view field) {
  constexpr std::size_t kMostQuoted = 40;  // bytes
  return field.substr(0, kMostQuoted);
}

}  // namespace t4d::tools
