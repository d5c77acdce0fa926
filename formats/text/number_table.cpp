#include "formats/text/number_table.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "model/units.h"

namespace t4d::formats {
namespace {

std::string lowerCase(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

std::string_view withoutBlanks(std::string_view text) {
  const auto isBlank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && isBlank(text.front())) text.remove_prefix(1);
  while (!text.empty() && isBlank(text.back())) text.remove_suffix(1);
  return text;
}

std::string_view unquoted(std::string_view text) {
  text = withoutBlanks(text);
  const bool quoted = text.size() >= 2 && text.front() == '"' && text.back() == '"';
  return quoted ? text.substr(1, text.size() - 2) : text;
}

/// A blank as the separator stands for any number of blanks and tabs.
std::vector<std::string_view> fieldsOf(std::string_view line, char separator) {
  std::vector<std::string_view> fields;
  if (separator == ' ') {
    for (line = withoutBlanks(line); !line.empty(); line = withoutBlanks(line)) {
      const auto end = std::min(line.find_first_of(" \t"), line.size());
      fields.push_back(unquoted(line.substr(0, end)));
      line.remove_prefix(end);
    }
    return fields;
  }
  while (true) {
    const auto end = line.find(separator);
    fields.push_back(unquoted(line.substr(0, end)));
    if (end == line.npos) return fields;
    line.remove_prefix(end + 1);
  }
}

char separatorOf(std::string_view line) {
  const auto has = [&](char c) { return line.find(c) != line.npos; };
  if (has(';')) return ';';
  if (!has('\t')) return has(',') ? ',' : ' ';
  // "time,<tab>x" is separated by commas, in "0,5<tab>1" they are in numbers.
  const auto fields = fieldsOf(line, '\t');
  const bool commas = std::ranges::any_of(fields, [](auto field) { return field.ends_with(','); });
  return commas ? ',' : '\t';
}

/// Whether a number such as 1,500 could also have thousands apart: up to three digits, not 0, and
/// three more.
bool mayBeThousands(std::string_view number) {
  if (number.starts_with('-') || number.starts_with('+')) number.remove_prefix(1);
  const auto comma = number.find(',');
  return comma >= 1 && comma <= 3 && number[0] != '0' && number.size() - comma == 4 &&
         number.find_first_of("eE") == number.npos;
}

bool isUnit(std::string_view text) {
  return text == "deg" || text == "rad" || model::metresPer(text).has_value() ||
         model::timeConversion(text, "s").has_value();
}

}  // namespace

NumberTable::NumberTable(const InputFile& file) : file_(file), scanner_(file, {.comment = '#'}) {}

Result<void> NumberTable::begin(AreNames areNames) {
  scanner_.nextLine();
  line_ = scanner_.line();
  const std::string_view line = scanner_.rest();
  separator_ = separatorOf(line);
  const auto fields = fieldsOf(line, separator_);
  if (separator_ == ' ') form_.emplace_back("columns are separated by blanks");
  if (!areNumbers(fields)) {
    names_.assign(fields.begin(), fields.end());
    return findDecimalComma();
  }
  first_ = line;
  names_ = namesInComment(fields.size(), areNames);
  if (names_.empty()) {
    unnamed_ = fields.size();
  } else {
    form_.emplace_back("their names are in a comment");
  }
  return findDecimalComma();
}

bool NumberTable::areNumbers(const std::vector<std::string_view>& fields) {
  return std::ranges::all_of(fields, [&](std::string_view field) {
    std::string pointed(field);
    std::ranges::replace(pointed, ',', '.');
    double number = 0;
    return scanner_.parse(pointed, number, "");
  });
}

/// The names in the last comment before the first row, as in `# timestamp tx ty tz qx qy qz qw`;
/// empty if that is not what it holds.
std::vector<std::string> NumberTable::namesInComment(std::size_t columns, AreNames areNames) {
  std::string_view comment;
  std::string_view rest = file_.bytes;
  for (std::uint64_t line = 1; line < line_; ++line) {
    const auto end = std::min(rest.find('\n'), rest.size());
    const std::string_view here = withoutBlanks(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (here.starts_with('#')) comment = here.substr(1);
  }
  const auto fields = fieldsOf(unquoted(comment), separatorOf(comment));
  std::vector<std::string> names(fields.begin(), fields.end());
  if (names.size() != columns || !areNames(names)) return {};
  return names;
}

/// Whether numbers have decimal commas, which they can where commas separate nothing.
Result<void> NumberTable::findDecimalComma() {
  if (separator_ == ',') return {};
  TextScanner lines = scanner_;
  std::string_view fieldsHere = first_.value_or("");
  std::uint64_t line = line_;
  std::string pointed;
  std::string unclear;
  std::uint64_t unclearLine = 0;
  bool certain = false;
  do {
    for (const std::string_view field : fieldsOf(fieldsHere, separator_)) {
      const auto commas = std::ranges::count(field, ',');
      if (commas == 0 && field.find('.') != field.npos && pointed.empty()) pointed = field;
      if (commas != 1 || field.find('.') != field.npos) continue;
      certain = certain || !mayBeThousands(field);
      if (unclear.empty()) {
        unclear = field;
        unclearLine = line;
      }
    }
    if (!lines.nextLine()) break;
    fieldsHere = lines.rest();
    line = lines.line();
  } while (true);
  if (unclear.empty()) return {};
  if (!pointed.empty()) {
    return invalid(fmt::format("found {} and {}: numbers have a decimal comma or a decimal point, "
                               "not both",
                               inQuotes(unclear), inQuotes(pointed)),
                   file_.atLine(unclearLine));
  }
  if (!certain) {
    return invalid(fmt::format("found {}, whose comma may be a decimal comma or stand between "
                               "thousands; write decimal points",
                               inQuotes(unclear)),
                   file_.atLine(unclearLine));
  }
  decimalComma_ = true;
  form_.emplace_back("numbers have decimal commas");
  return {};
}

bool NumberTable::nextRow() {
  if (first_) {
    fields_ = fieldsOf(*first_, separator_);
    first_.reset();
    return true;
  }
  if (!scanner_.nextLine()) return false;
  line_ = scanner_.line();
  fields_ = fieldsOf(scanner_.rest(), separator_);
  return true;
}

Result<void> NumberTable::numbers(std::span<const std::size_t> columns, std::span<double> into) {
  if (fields_.size() != names_.size()) {
    return invalidHere(
        fmt::format("has {} fields, but {} columns are named", fields_.size(), names_.size()));
  }
  for (std::size_t i = 0; i < columns.size(); ++i) {
    std::string field(fields_[columns[i]]);
    if (decimalComma_) std::ranges::replace(field, ',', '.');
    if (!scanner_.parse(field, into[i], "a number")) {
      return invalidHere(fmt::format("column {}: found {}, expected a number", names_[columns[i]],
                                     inQuotes(fields_[columns[i]])));
    }
  }
  return {};
}

std::string noticeOfUnread(std::vector<std::string> columns) {
  constexpr std::size_t kMostNamed = 6;
  const std::size_t more = columns.size() > kMostNamed ? columns.size() - kMostNamed : 0;
  columns.resize(columns.size() - more);
  for (std::string& name : columns) name = inQuotes(name);
  return fmt::format("columns that are not read: {}{}", fmt::join(columns, " "),
                     more > 0 ? fmt::format(" and {} more", more) : "");
}

ColumnName columnName(std::string_view name) {
  const auto bracket = name.find_first_of("[(");
  if (bracket != name.npos && bracket > 0 && (name.back() == ']' || name.back() == ')')) {
    return {lowerCase(withoutBlanks(name.substr(0, bracket))),
            std::string(withoutBlanks(name.substr(bracket + 1, name.size() - bracket - 2)))};
  }
  const auto low = name.rfind('_');
  if (low != name.npos && low > 0 && isUnit(name.substr(low + 1))) {
    return {lowerCase(name.substr(0, low)), std::string(name.substr(low + 1))};
  }
  return {lowerCase(name), {}};
}

}  // namespace t4d::formats
