#include "t4d/formats/usd/usd_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "t4d/formats/text/text_scanner.h"
#include "t4d/formats/zip_entry.h"

namespace t4d::formats {
namespace {

constexpr std::string_view kUsdBinary = "PXR-USDC";
constexpr std::string_view kUsdHeader = "#usda ";
constexpr std::string_view kZipHeader("PK\x03\x04", 4);

bool isWordCharacter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
         c == ':' || c == '.' || c == '|' || static_cast<unsigned char>(c) >= 0x80;
}

bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

/// Nothing in the text is nested deeper, or the text is an attack.
constexpr std::size_t kDeepest = 128;

/// Reads the text from left to right.
class UsdScanner {
 public:
  UsdScanner(const UsdDocument& document, std::string_view text)
      : document_(document), text_(text) {}

  bool atEnd() const { return at_ >= text_.size(); }
  char peek() const { return atEnd() ? '\0' : text_[at_]; }
  std::size_t at() const { return at_; }
  std::string_view from(std::size_t begin) const { return text_.substr(begin, at_ - begin); }

  void skipBlanks() {
    while (!atEnd()) {
      const std::string_view rest = text_.substr(at_, 2);
      if (isBlank(text_[at_])) {
        ++at_;
      } else if (text_[at_] == '#' || rest == "//") {
        at_ = std::min(text_.find('\n', at_), text_.size());
      } else if (rest == "/*") {
        const std::size_t end = text_.find("*/", at_ + 2);
        at_ = end == text_.npos ? text_.size() : end + 2;
      } else {
        return;
      }
    }
  }

  /// Takes the character, after blanks, if it is the next one.
  bool take(char c) {
    skipBlanks();
    if (peek() != c || atEnd()) return false;
    ++at_;
    return true;
  }

  Result<void> expect(char c, std::string_view what) {
    return take(c) ? Result<void>() : Result<void>(unexpected(what));
  }

  std::string_view word() {
    skipBlanks();
    const std::size_t begin = at_;
    while (!atEnd() && isWordCharacter(text_[at_])) ++at_;
    return from(begin);
  }

  Error unexpected(std::string_view what) const {
    if (atEnd()) return invalid(fmt::format("the text ends, expected {}", what), here());
    std::size_t end = at_;
    while (end < text_.size() && !isBlank(text_[end]) && end < at_ + 40) ++end;
    return invalid(
        fmt::format("found {}, expected {}", inQuotes(text_.substr(at_, end - at_)), what), here());
  }
  Error invalidAt(std::string_view part, std::string message) const {
    return invalid(std::move(message), document_.where(part));
  }
  Place here() const { return document_.where(text_.substr(std::min(at_, text_.size()), 0)); }

  Result<double> number(std::string_view what) {
    skipBlanks();
    const std::size_t sign = peek() == '+' ? 1 : 0;
    const char* const begin = text_.data() + at_ + sign;
    double found = 0;
    const auto [stop, problem] = std::from_chars(begin, text_.data() + text_.size(), found);
    if (problem != std::errc{}) return unexpected(what);
    at_ += sign + static_cast<std::size_t>(stop - begin);
    return found;
  }

  /// A string of either quotes, single or triple.
  Result<std::string_view> string() {
    skipBlanks();
    const std::size_t begin = at_;
    const char quote = peek();
    if (quote != '"' && quote != '\'') return unexpected("a string");
    const bool triple = text_.substr(at_, 3) == std::string(3, quote);
    at_ += triple ? 3 : 1;
    for (; !atEnd(); ++at_) {
      if (text_[at_] == '\\') {
        ++at_;
      } else if (triple && text_.substr(at_, 3) == std::string(3, quote)) {
        at_ += 3;
        return from(begin);
      } else if (!triple && text_[at_] == quote) {
        ++at_;
        return from(begin);
      } else if (!triple && text_[at_] == '\n') {
        break;
      }
    }
    at_ = begin;
    return unexpected("a string that ends");
  }

  /// Any value, as its text.
  Result<std::string_view> value() {
    skipBlanks();
    const std::size_t begin = at_;
    switch (peek()) {
      case '"':
      case '\'':
        return string();
      case '[':
      case '(':
      case '{':
        if (auto done = skipNested(); !done) return done.error();
        return from(begin);
      case '<':
        if (auto done = skipPath(); !done) return done.error();
        return from(begin);
      case '@':
        return asset();
      default:
        while (!atEnd() &&
               (isWordCharacter(text_[at_]) || text_[at_] == '-' || text_[at_] == '+')) {
          ++at_;
        }
        if (at_ == begin) return unexpected("a value");
        return from(begin);
    }
  }

 private:
  Result<void> skipPath() {
    const std::size_t end = text_.find_first_of(">\n", at_);
    if (end == text_.npos || text_[end] != '>') return unexpected("a path that ends with >");
    at_ = end + 1;
    return {};
  }

  Result<void> skipAsset() {
    const std::string_view mark = text_.substr(at_, 3) == "@@@" ? "@@@" : "@";
    const std::size_t end = text_.find(mark, at_ + mark.size());
    if (end == text_.npos) return unexpected("the name of a file that ends with @");
    at_ = end + mark.size();
    return {};
  }

  /// With the prim in it, and its offset in time.
  Result<std::string_view> asset() {
    const std::size_t begin = at_;
    if (auto done = skipAsset(); !done) return done.error();
    if (peek() == '<') {
      if (auto done = skipPath(); !done) return done.error();
    }
    const std::size_t end = at_;
    skipBlanks();
    if (peek() != '(') return text_.substr(begin, end - begin);
    if (auto done = skipNested(); !done) return done.error();
    return from(begin);
  }

  /// What is in brackets of any kind.
  Result<void> skipNested() {
    const std::size_t begin = at_;
    std::string closers;
    while (!atEnd()) {
      const char c = text_[at_];
      if (c == '[' || c == '(' || c == '{') {
        if (closers.size() == kDeepest) return unexpected("brackets that are not nested as deep");
        closers += c == '[' ? ']' : c == '(' ? ')' : '}';
        ++at_;
      } else if (c == ']' || c == ')' || c == '}') {
        if (closers.back() != c) return unexpected(fmt::format("'{}'", closers.back()));
        closers.pop_back();
        ++at_;
        if (closers.empty()) return {};
      } else if (c == '"' || c == '\'') {
        if (auto done = string(); !done) return done.error();
      } else if (c == '@') {
        if (auto done = skipAsset(); !done) return done;
      } else if (c == '<') {
        if (auto done = skipPath(); !done) return done;
      } else if (c == '#' || c == '/') {
        const std::size_t before = at_;
        skipBlanks();
        at_ = std::max(at_, before + 1);
      } else {
        ++at_;
      }
    }
    at_ = begin;
    return invalid(fmt::format("the text ends in brackets that begin here"), here());
  }

  const UsdDocument& document_;
  std::string_view text_;
  std::size_t at_ = 0;
};

bool isOneOf(std::string_view word, std::initializer_list<std::string_view> words) {
  return std::ranges::find(words, word) != words.end();
}

class UsdParser {
 public:
  explicit UsdParser(const UsdDocument& document) : in_(document, document.text) {}

  Result<UsdLayer> read() {
    UsdLayer layer;
    in_.skipBlanks();  // the first line is a comment, too
    if (in_.take('(')) {
      if (auto done = metadata(layer.metadata); !done) return done.error();
    }
    for (skipSeparators(); !in_.atEnd(); skipSeparators()) {
      const std::string_view word = in_.word();
      if (word == "reorder") {
        if (auto done = reorder(); !done) return done.error();
      } else if (isOneOf(word, {"def", "over", "class"})) {
        auto made = prim(word, 0);
        if (!made) return made.error();
        layer.prims.push_back(std::move(*made));
      } else {
        return in_.unexpected("def, over or class");
      }
    }
    return layer;
  }

 private:
  void skipSeparators() {
    do {
      in_.skipBlanks();
    } while (in_.take(';'));
  }

  /// `reorder rootPrims = [...]`
  Result<void> reorder() {
    in_.word();
    if (auto done = in_.expect('=', "="); !done) return done;
    const auto value = in_.value();
    return value ? Result<void>() : Result<void>(value.error());
  }

  /// Behind its parenthesis.
  Result<void> metadata(std::vector<UsdField>& fields) {
    while (true) {
      skipSeparators();
      if (in_.take(')')) return {};
      if (in_.peek() == '"' || in_.peek() == '\'') {
        if (auto comment = in_.string(); !comment) return comment.error();
        continue;
      }
      std::string_view key = in_.word();
      if (isOneOf(key, {"add", "append", "prepend", "delete", "reorder"})) key = in_.word();
      if (key.empty()) return in_.unexpected("the name of a field, or )");
      if (auto done = in_.expect('=', "="); !done) return done;
      const auto value = in_.value();
      if (!value) return value.error();
      fields.push_back({key, *value});
    }
  }

  Result<void> skipMetadata() {
    std::vector<UsdField> ignored;
    return in_.take('(') ? metadata(ignored) : Result<void>();
  }

  /// Behind its specifier.
  Result<UsdPrim> prim(std::string_view specifier, std::size_t depth) {
    UsdPrim made{specifier};
    if (depth == kDeepest) return in_.unexpected("prims that are not nested as deep");
    made.type = in_.word();
    const auto name = in_.string();
    if (!name) return name.error();
    made.name = name->substr(1, name->size() - 2);
    if (in_.take('(')) {
      if (auto done = metadata(made.metadata); !done) return done.error();
    }
    if (auto done = in_.expect('{', "{"); !done) return done.error();
    std::map<std::string_view, std::size_t> numbers;  // of properties
    while (true) {
      skipSeparators();
      if (in_.take('}')) return made;
      const std::string_view word = in_.word();
      Result<void> done;
      if (isOneOf(word, {"def", "over", "class"})) {
        auto child = prim(word, depth + 1);
        if (!child) return child;
        made.children.push_back(std::move(*child));
      } else if (word == "variantSet") {
        done = variantSet(made);
      } else if (word == "reorder") {
        done = reorder();
      } else if (word.empty()) {
        return in_.unexpected("a property, a prim or }");
      } else {
        done = property(word, made, numbers);
      }
      if (!done) return done.error();
    }
  }

  Result<void> variantSet(UsdPrim& made) {
    const auto name = in_.string();
    if (!name) return name.error();
    made.variantSet = *name;
    if (auto done = in_.expect('=', "="); !done) return done;
    const auto value = in_.value();
    return value ? Result<void>() : Result<void>(value.error());
  }

  Result<void> property(std::string_view word, UsdPrim& of,
                        std::map<std::string_view, std::size_t>& numbers) {
    while (isOneOf(
        word, {"custom", "uniform", "varying", "config", "add", "append", "prepend", "delete"})) {
      word = in_.word();
    }
    const std::string_view type = word;
    if (in_.take('[')) {
      if (auto done = in_.expect(']', "]"); !done) return done;
    }
    std::string_view name = in_.word();
    if (type.empty() || name.empty()) return in_.unexpected("the type and the name of a property");
    std::string_view suffix;
    if (const std::size_t dot = name.find('.'); dot != name.npos) {
      suffix = name.substr(dot + 1);
      name = name.substr(0, dot);
    }
    const auto [found, added] = numbers.emplace(name, of.properties.size());
    if (added) of.properties.push_back({type, name});
    UsdProperty& made = of.properties[found->second];
    if (in_.take('=')) {
      if (suffix == "timeSamples") {
        if (auto done = samples(made); !done) return done;
      } else {
        const auto value = in_.value();
        if (!value) return value.error();
        if (suffix.empty()) made.value = *value;
        if (suffix == "spline") made.isSpline = true;
      }
    }
    return skipMetadata();
  }

  Result<void> samples(UsdProperty& made) {
    if (auto done = in_.expect('{', "{ of time samples"); !done) return done;
    made.samples.clear();
    while (!in_.take('}')) {
      UsdSample sample;
      const auto code = in_.number("a time code");
      if (!code) return code.error();
      if (!std::isfinite(*code)) return in_.unexpected("a finite time code before this");
      sample.timeCode = *code;
      if (auto done = in_.expect(':', ": behind a time code"); !done) return done;
      const auto value = in_.value();
      if (!value) return value.error();
      sample.value = *value;
      made.samples.push_back(sample);
      if (in_.take(',')) continue;
      if (auto done = in_.expect('}', ", or }"); !done) return done;
      break;
    }
    std::ranges::stable_sort(made.samples, {}, &UsdSample::timeCode);
    const auto twice = std::ranges::adjacent_find(made.samples, {}, &UsdSample::timeCode);
    if (twice == made.samples.end()) return {};
    return in_.invalidAt(std::next(twice)->value,
                         fmt::format("a second sample at time code {}", twice->timeCode));
  }

  UsdScanner in_;
};

/// Reads what values consist of, into one list.
class UsdNumberReader {
 public:
  UsdNumberReader(const UsdDocument& document, std::string_view value, std::size_t width,
                  bool rounded)
      : in_(document, value), width_(width), rounded_(rounded) {}

  Result<std::vector<double>> array() {
    if (auto done = in_.expect('[', "["); !done) return done.error();
    while (!in_.take(']')) {
      if (auto done = element(); !done) return done.error();
      if (in_.take(',')) continue;
      if (auto done = in_.expect(']', ", or ]"); !done) return done.error();
      break;
    }
    return std::move(numbers_);
  }

  Result<std::vector<double>> one() {
    if (auto done = element(); !done) return done.error();
    return std::move(numbers_);
  }

 private:
  Result<void> element() {
    const std::size_t before = numbers_.size();
    if (auto done = tuple(0); !done) return done;
    if (numbers_.size() - before == width_) return {};
    return in_.unexpected(
        fmt::format("{} numbers before this, not {}", width_, numbers_.size() - before));
  }

  Result<void> tuple(std::size_t depth) {
    in_.skipBlanks();
    if (in_.peek() != '(') return number();
    constexpr std::size_t kRowsAndColumns = 2;
    if (depth == kRowsAndColumns) return in_.unexpected("a number");
    in_.take('(');
    do {
      if (auto done = tuple(depth + 1); !done) return done;
    } while (in_.take(','));
    return in_.expect(')', ", or )");
  }

  Result<void> number() {
    const auto number = in_.number("a number");
    if (!number) return number.error();
    numbers_.push_back(rounded_ ? static_cast<double>(static_cast<float>(*number)) : *number);
    return {};
  }

  UsdScanner in_;
  std::size_t width_;
  bool rounded_;
  std::vector<double> numbers_;
};

bool isDouble(std::string_view type) {
  return type.starts_with("double") || type.starts_with("int") || type.ends_with('d');
}

}  // namespace

Place UsdDocument::where(std::string_view part) const {
  const auto before =
      std::string_view(text.data(), static_cast<std::size_t>(part.data() - text.data()));
  return file->atLine(1 + static_cast<std::uint64_t>(std::ranges::count(before, '\n')));
}

const UsdProperty* UsdPrim::property(std::string_view wanted) const {
  const auto found = std::ranges::find(properties, wanted, &UsdProperty::name);
  return found == properties.end() ? nullptr : &*found;
}

std::optional<std::string_view> UsdPrim::field(std::string_view wanted) const {
  const auto found = std::ranges::find(metadata, wanted, &UsdField::key);
  return found == metadata.end() ? std::nullopt : std::optional(found->value);
}

std::optional<std::string_view> UsdLayer::field(std::string_view wanted) const {
  const auto found = std::ranges::find(metadata, wanted, &UsdField::key);
  return found == metadata.end() ? std::nullopt : std::optional(found->value);
}

Result<UsdDocument> openUsd(InputFile file) {
  UsdDocument document;
  document.file = std::make_shared<const InputFile>(std::move(file));
  document.text = document.file->bytes;
  const std::string name = document.file->path.string();
  std::string_view within;
  if (document.text.starts_with(kZipHeader)) {
    const auto entry = firstZipEntry(*document.file);
    if (!entry) return entry.error();
    document.text = entry->bytes;
    within = entry->name;
  }
  if (document.text.starts_with(kUsdBinary)) {
    const std::string inner = within.empty() ? "" : fmt::format(", {},", inQuotes(within));
    return fail(ErrorCode::Unsupported,
                fmt::format("is binary USD{} of which only text is read; `usdcat --flatten IN.usd "
                            "-o OUT.usda` converts it",
                            inner),
                name);
  }
  if (document.text.starts_with(kUsdHeader)) return document;
  return invalid(fmt::format("begins with {}, expected #usda",
                             inQuotes(document.text.substr(
                                 0, std::min<std::size_t>(16, document.text.size())))),
                 name, Remedy::OtherFormat);
}

Result<UsdLayer> readUsdLayer(const UsdDocument& document) { return UsdParser(document).read(); }

Result<std::vector<double>> usdNumbers(const UsdDocument& document, std::string_view value,
                                       std::size_t width, UsdShapeOf shape, std::string_view type) {
  UsdNumberReader reader(document, value, width, !isDouble(type));
  return shape == UsdShapeOf::Array ? reader.array() : reader.one();
}

std::string usdUnquoted(std::string_view value) {
  if (value.size() < 2 || (value[0] != '"' && value[0] != '\'')) return std::string(value);
  const std::size_t marks =
      value.size() >= 6 && value[1] == value[0] && value[2] == value[0] ? 3 : 1;
  const std::string_view inner = value.substr(marks, value.size() - 2 * marks);
  std::string text;
  for (std::size_t i = 0; i < inner.size(); ++i) {
    if (inner[i] != '\\' || i + 1 == inner.size()) {
      text += inner[i];
      continue;
    }
    const char next = inner[++i];
    unsigned code = 0;
    if (next == 'x' && i + 2 < inner.size() &&
        std::from_chars(&inner[i + 1], &inner[i + 1] + 2, code, 16).ec == std::errc{}) {
      text += static_cast<char>(code);
      i += 2;
    } else {
      text += next == 'n' ? '\n' : next == 't' ? '\t' : next == 'r' ? '\r' : next;
    }
  }
  return text;
}

Result<std::vector<std::string>> usdTokens(const UsdDocument& document, std::string_view value) {
  UsdScanner in(document, value);
  std::vector<std::string> tokens;
  if (auto done = in.expect('[', "["); !done) return done.error();
  while (!in.take(']')) {
    const auto token = in.string();
    if (!token) return token.error();
    tokens.push_back(usdUnquoted(*token));
    if (in.take(',')) continue;
    if (auto done = in.expect(']', ", or ]"); !done) return done.error();
    break;
  }
  return tokens;
}

}  // namespace t4d::formats
