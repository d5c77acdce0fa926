#include "formats/toolpath/tool_table.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "formats/input_file.h"
#include "formats/text/text_scanner.h"
#include "model/limits.h"
#include "model/number.h"

namespace t4d::formats {
namespace {

constexpr std::string_view kSkipped = "PDIJQABCUVW";
constexpr double kLargestNumber = 99'999;

struct NumberedTool {
  std::optional<int> number;
  TableTool tool;
};

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r";
  const auto begin = std::min(text.find_first_not_of(kBlanks), text.size());
  text.remove_prefix(begin);
  return text.substr(0, text.find_last_not_of(kBlanks) + 1);
}

/// Takes a word as in Z50.8.
Result<void> take(std::string_view word, NumberedTool& into) {
  const char letter = word[0] >= 'a' && word[0] <= 'z' ? static_cast<char>(word[0] - 32) : word[0];
  const auto number = model::numberIn<double>(model::withoutPlus(word.substr(1)));
  const double value = number.value_or(0);
  const bool isNumber = number && std::abs(value) <= model::kLargestCoordinate;
  const bool isLength = letter >= 'X' && letter <= 'Z';
  const bool isKnown = letter == 'T' || isLength || kSkipped.find(letter) != std::string_view::npos;
  if (!isNumber || !isKnown) {
    return invalid(
        fmt::format("found {}, expected T, P, X, Y, Z or D and a number, as in T1 P1 "
                    "Z50.8 D6 ;a remark",
                    inQuotes(word)));
  }
  if (isLength) into.tool.length[letter - 'X'] = value;
  if (letter != 'T') return {};
  if (!(value >= 0 && value <= kLargestNumber) || value != std::floor(value)) {
    return invalid(fmt::format("{} is not the number of a tool", inQuotes(word)));
  }
  into.number = static_cast<int>(value);
  return {};
}

Result<NumberedTool> toolOf(std::string_view line) {
  NumberedTool found;
  const auto semicolon = std::min(line.find(';'), line.size());
  found.tool.remark = trimmed(line.substr(std::min(semicolon + 1, line.size())));
  std::string_view rest = trimmed(line.substr(0, semicolon));
  const bool isEmpty = rest.empty();
  while (!rest.empty()) {
    const std::string_view word = rest.substr(0, rest.find_first_of(" \t"));
    if (auto taken = take(word, found); !taken) return taken.error();
    rest = trimmed(rest.substr(word.size()));
  }
  if (!isEmpty && !found.number) return invalid("the line has no T, the number of the tool");
  return found;
}

}  // namespace

Result<std::map<int, TableTool>> readToolTable(const InputFile& file) {
  std::map<int, TableTool> tools;
  std::string_view text = file.bytes;
  for (std::uint64_t number = 1; !text.empty(); ++number) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    auto tool = toolOf(line);
    if (!tool) return invalid(tool.error().message, file.atLine(number));
    if (!tool->number) continue;
    if (!tools.emplace(*tool->number, std::move(tool->tool)).second) {
      return invalid(fmt::format("T{} comes a second time", *tool->number), file.atLine(number));
    }
  }
  if (tools.empty()) return invalid("holds no tool", file.path.string());
  return tools;
}

Result<std::map<int, TableTool>> readToolTable(const std::filesystem::path& path) {
  const auto file = readInputFile(path);
  if (!file) return file.error();
  return readToolTable(*file);
}

}  // namespace t4d::formats
