#include "tools/t4d/console.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "platform/process.h"
#include "tools/t4d/hints.h"
#include "tools/t4d/json_text.h"

namespace t4d::tools {

namespace {

int firstPrintError = 0;
bool quiet = false;
bool quietResults = false;

/// fmt::print would throw if nothing can be written.
void printOnStandardError(const std::string& text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
}

bool continuesCharacter(char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U; }

/// The text without its middle part if it is long.
std::string shortened(const std::string& text) {
  constexpr std::size_t kLongest = 2000;
  constexpr std::size_t kEnd = 500;
  if (text.size() <= kLongest) return text;
  std::size_t cut = kLongest - kEnd;
  std::size_t resume = text.size() - kEnd;
  while (cut > 0 && continuesCharacter(text[cut])) --cut;
  while (resume < text.size() && continuesCharacter(text[resume])) ++resume;
  return text.substr(0, cut) + " [...] " + text.substr(resume);
}

/// The length of the character of UTF-8 at the beginning of a text; 0 for what is none, and for
/// characters that command a terminal: controls, and those that change the direction of writing.
std::size_t printableLength(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned first = byte(0);
  if (first < 0x80) return first >= 0x20 && first != 0x7F ? 1 : 0;
  const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4 || text.size() < length) return 0;
  std::uint32_t point = first & (0x7FU >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0U) != 0x80) return 0;
    point = point << 6U | (byte(i) & 0x3FU);
  }
  const bool control = point < 0xA0;
  const bool direction =
      (point >= 0x202A && point <= 0x202E) || (point >= 0x2066 && point <= 0x2069);
  return control || direction ? 0 : length;
}

}  // namespace

void beQuiet(bool results) {
  quiet = true;
  ProgressBar::silence();
  if (results) hideResults();
}

void hideResults() { quietResults = true; }

void printResult(const std::string& text) {
  if (!quietResults) printText(shown(text));
}

void printText(std::string_view text) {
  errno = 0;
  const bool printed = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  if (!printed && firstPrintError == 0) firstPrintError = errno;
}

void printExtra(const std::vector<std::string>& lines) {
  for (const std::string& line : lines) {
    if (!line.empty()) print("  {}\n", line);
  }
}

int printError() {
  errno = 0;
  const bool flushed = std::fflush(stdout) == 0;
  if (!flushed && firstPrintError == 0) firstPrintError = errno;
  return firstPrintError;
}

std::string shown(std::string_view text) {
  std::string result;
  while (true) {
    const auto end = text.find('\n');
    result += shownLine(text.substr(0, end));
    if (end == text.npos) return result;
    result += '\n';
    text.remove_prefix(end + 1);
  }
}

std::string shownLine(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  while (!text.empty()) {
    const std::size_t length = printableLength(text);
    if (text.front() == '\n') {
      result += "\\n";
    } else if (length == 0) {
      result += fmt::format("\\x{:02x}", static_cast<unsigned char>(text.front()));
    } else {
      result += text.substr(0, length);
    }
    text.remove_prefix(std::max<std::size_t>(1, length));
  }
  return result;
}

void sayAsIs(const std::string& text) { printOnStandardError(shown(shortened(text))); }

void say(const std::string& message) { sayAsIs("t4d: " + shownLine(message) + "\n"); }

int wrongUsage(const std::string& message) {
  say(message);
  return kUsage;
}

int report(const Error& error) {
  say(error.text());
  const std::string hint = hintFor(error);
  sayHint(hint);
  constexpr std::size_t kMostOthers = 20;
  for (std::size_t i = 0; i < error.others.size(); ++i) {
    if (i == kMostOthers) {
      say(fmt::format("and {} more", error.others.size() - i));
      break;
    }
    say(error.others[i].text());
    if (const std::string more = hintFor(error.others[i]); more != hint) sayHint(more);
  }
  switch (error.code) {
    case ErrorCode::Failed:
      return kFailed;
    case ErrorCode::Options:
      return kUsage;
    default:
      return kInvalid;
  }
}

void sayHint(const std::string& hint) {
  if (!hint.empty()) say(hint);
}

void printNotices(const std::vector<std::string>& notices) {
  if (quiet) return;
  for (const std::string& notice : notices) say("note: " + notice);
}

int reportLosses(const std::vector<std::string>& losses) {
  for (const std::string& loss : losses) say("lost: " + loss);
  return losses.empty() ? kDone : kLoss;
}

void printJson(const nlohmann::ordered_json& value) { printText(jsonText(value) + "\n"); }

void printTable(const std::vector<std::vector<std::string>>& rows, std::string_view alignment) {
  std::vector<std::size_t> widths(rows.front().size());
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (i > 0) line += "   ";
      line += alignment[std::min(i, alignment.size() - 1)] == 'l'
                  ? fmt::format("{:<{}}", row[i], widths[i])
                  : fmt::format("{:>{}}", row[i], widths[i]);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    print("{}\n", line);
  }
}

std::uint64_t peakBytes() {
  return std::max(platform::peakBytes(), platform::peakBytesOfChildren());
}

}  // namespace t4d::tools
