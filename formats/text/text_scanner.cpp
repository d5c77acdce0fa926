#include "formats/text/text_scanner.h"

#include <cctype>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "model/number.h"

namespace t4d::formats {
namespace {

constexpr std::size_t kLongestQuote = 40;

bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }

/// The nearest double of a well-formed number that from_chars finds out of range: zero where it is
/// too small, infinity where it is too large.
double outOfRange(std::string_view word) {
  if (const auto wide = model::numberIn<long double>(word)) return static_cast<double>(*wide);
  const auto exponent = word.find_first_of("eE");
  const bool tiny = exponent != word.npos && word.substr(exponent + 1).starts_with('-');
  return tiny ? 0.0 : std::numeric_limits<double>::infinity();
}

/// False if the word is not a whole number of this type.
template <class Whole>
bool parseWhole(std::string_view word, Whole& value) {
  const auto number = model::numberIn<Whole>(model::withoutPlus(word));
  value = number.value_or(value);
  return number.has_value();
}

}  // namespace

std::string inQuotes(std::string_view word) {
  std::string text = "'";
  for (const char c : word.substr(0, kLongestQuote)) {
    text += std::isprint(static_cast<unsigned char>(c)) ? c : '?';
  }
  return text + (word.size() > kLongestQuote ? "...'" : "'");
}

TextScanner::TextScanner(const InputFile& file, TextRules rules)
    : file_(file), text_(file.bytes), rules_(rules) {
  // A byte order mark is not part of the first word.
  if (text_.starts_with("\xEF\xBB\xBF")) at_ = 3;
}

std::size_t TextScanner::lineBreakAt(std::size_t at) const {
  if (at >= text_.size()) return 0;
  if (text_[at] == '\n') return 1;
  if (text_[at] != '\r') return 0;
  return at + 1 < text_.size() && text_[at + 1] == '\n' ? 2 : 1;
}

void TextScanner::skipBlanks() {
  while (at_ < text_.size()) {
    if (isBlank(text_[at_])) {
      ++at_;
    } else if (rules_.continuation && text_[at_] == '\\' && lineBreakAt(at_ + 1) > 0) {
      at_ += 1 + lineBreakAt(at_ + 1);
      ++line_;
    } else if (rules_.comment != '\0' && text_[at_] == rules_.comment) {
      while (at_ < text_.size() && lineBreakAt(at_) == 0) ++at_;
      return;
    } else {
      return;
    }
  }
}

bool TextScanner::hasWord() {
  skipBlanks();
  return at_ < text_.size() && lineBreakAt(at_) == 0;
}

std::string_view TextScanner::word() {
  if (!hasWord()) return {};
  const std::size_t begin = at_;
  while (at_ < text_.size()) {
    const char c = text_[at_];
    if (isBlank(c) || c == '\n' || c == '\r') break;
    if (rules_.comment != '\0' && c == rules_.comment) break;
    if (rules_.continuation && c == '\\' && lineBreakAt(at_ + 1) > 0) break;
    ++at_;
  }
  return text_.substr(begin, at_ - begin);
}

std::string_view TextScanner::rest() {
  skipBlanks();
  const std::size_t begin = at_;
  while (at_ < text_.size() && lineBreakAt(at_) == 0) ++at_;
  auto line = text_.substr(begin, at_ - begin);
  while (!line.empty() && isBlank(line.back())) line.remove_suffix(1);
  return line;
}

bool TextScanner::nextLine() {
  if (!std::exchange(started_, true) && hasWord()) return true;
  while (at_ < text_.size()) {
    while (hasWord()) word();
    const std::size_t lineBreak = lineBreakAt(at_);
    if (lineBreak == 0) return false;
    // Errors at the end of the text get the number of the last line.
    at_ += lineBreak;
    if (at_ < text_.size()) ++line_;
    if (hasWord()) return true;
  }
  return false;
}

std::size_t TextScanner::skipLineBreak() {
  at_ += lineBreakAt(at_);
  return at_;
}

std::string_view TextScanner::wordAcrossLines() {
  const auto found = word();
  if (!found.empty() || !nextLine()) return found;
  return word();
}

bool TextScanner::fails(std::string_view word, const char* what) {
  error_ = unexpectedWord(word, what);
  return false;
}

Error TextScanner::unexpectedWord(std::string_view word, std::string_view what) const {
  if (!word.empty()) return invalidHere(fmt::format("found {}, expected {}", inQuotes(word), what));
  const bool atEnd = at_ >= text_.size();
  return invalidHere(fmt::format("the {} ends, expected {}", atEnd ? "file" : "line", what));
}

bool TextScanner::parse(std::string_view word, double& value, const char* what) {
  const auto digits = model::withoutPlus(word);
  const auto [stopped, problem] = model::fromChars(digits, value);
  if (stopped != digits.data() + digits.size() || problem == std::errc::invalid_argument)
    return fails(word, what);
  if (problem == std::errc::result_out_of_range) value = outOfRange(digits);
  return true;
}

bool TextScanner::parse(std::string_view word, std::int64_t& value, const char* what) {
  return parseWhole(word, value) || fails(word, what);
}

bool TextScanner::parse(std::string_view word, std::uint64_t& value, const char* what) {
  return parseWhole(word, value) || fails(word, what);
}

bool TextScanner::number(double& value, const char* what) { return parse(word(), value, what); }

bool TextScanner::integer(std::int64_t& value, const char* what) {
  return parse(word(), value, what);
}

}  // namespace t4d::formats
