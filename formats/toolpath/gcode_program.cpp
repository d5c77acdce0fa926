#include "formats/toolpath/gcode_program.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "formats/text/text_scanner.h"
#include "formats/toolpath/gcode_words.h"
#include "model/number.h"

namespace t4d::formats {
namespace {

/// Skips the / of a line that may be left out, and N with its number, which is `number` then.
std::string_view withoutNumber(std::string_view text, bool& isOptional, std::string_view& number) {
  isOptional = text.starts_with('/');
  if (isOptional) text.remove_prefix(1);
  number = {};
  if (!text.starts_with('N')) return text;
  const auto digits = std::min(text.find_first_not_of("0123456789.", 1), text.size());
  number = text.substr(1, digits - 1);
  return digits == 1 ? text : text.substr(digits);
}

std::string_view withoutNumber(std::string_view text, bool& isOptional) {
  std::string_view number;
  return withoutNumber(text, isOptional, number);
}

std::string_view digitsOf(std::string_view text) {
  return text.substr(0, std::min(text.find_first_not_of("0123456789"), text.size()));
}

/// The label without leading zeros: "0100" and "100" are the same label.
std::string labelOf(std::string_view digits) {
  const auto first = digits.find_first_not_of('0');
  return std::string(first == digits.npos ? "0" : digits.substr(first));
}

/// Labels of WHILE and END are "DO 1", which no other label can be.
std::string oWordName(std::string_view label) {
  if (label.starts_with("DO ")) return std::string(label);
  return digitsOf(label) == label ? fmt::format("O{}", label) : fmt::format("O<{}>", label);
}

/// Whether a line has this M word.
bool hasM(std::string_view text, int code) {
  for (auto at = text.find('M'); at != text.npos; at = text.find('M', at + 1)) {
    std::string_view rest = text.substr(at + 1);
    if (model::takeNumber<int>(rest) == code) return true;
  }
  return false;
}

/// The arguments of G65: A to #1 and so on.
std::map<int, double> argumentsOf(const GcodeBlock& block) {
  // By letter, from A; 0: none.
  constexpr std::array<int, 26> kParameters = {1, 2, 3, 7,  8,  9,  0,  11, 4,  5,  6,  0,  13,
                                               0, 0, 0, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26};
  std::map<int, double> arguments;
  for (std::size_t i = 0; i < kParameters.size(); ++i) {
    if (kParameters[i] > 0 && block.arguments[i]) arguments[kParameters[i]] = *block.arguments[i];
  }
  return arguments;
}

}  // namespace

GcodeProgram::GcodeProgram(std::string_view text, GcodeDialect dialect, GcodeParameters& parameters,
                           Apply apply)
    : dialect_(dialect), parameters_(parameters), apply_(std::move(apply)), calls_(1) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  while (!text.empty()) {
    const auto end = std::min(text.find_first_of("\r\n"), text.size());
    lines_.push_back(text.substr(0, end));
    const bool two = text.substr(end).starts_with("\r\n");
    text.remove_prefix(std::min(end + (two ? 2 : 1), text.size()));
  }
}

Result<void> GcodeProgram::run(std::uint64_t repeatedLines) {
  if (auto found = findOWords(); !found) return found;
  const std::uint64_t most = lines_.size() + repeatedLines;
  std::uint64_t done = 0;
  for (at_ = 0; at_ < lines_.size() && !ended_; at_ = next_) {
    if (++done > most) {
      return fail(ErrorCode::Unsupported,
                  fmt::format("{} lines have been carried out, {} more than the program has; it "
                              "may never end",
                              most, repeatedLines));
    }
    next_ = at_ + 1;
    if (auto ran = runLine(); !ran) return ran;
  }
  if (ended_ || calls_.size() < 2) return {};
  at_ = calls_.back().begin;
  return invalid(
      fmt::format("the subprogram that begins here is called in line {} and has no end (M99)",
                  calls_.back().from + 1));
}

Result<GcodeProgram::OWord> GcodeProgram::oWordOf(std::string_view text) {
  static constexpr std::array<std::pair<std::string_view, Flow>, 15> kWords = {{
      {"SUB", Flow::Sub},
      {"ENDSUB", Flow::EndSub},
      {"CALL", Flow::Call},
      {"RETURN", Flow::Return},
      {"DO", Flow::Do},
      {"WHILE", Flow::While},
      {"ENDWHILE", Flow::EndWhile},
      {"IF", Flow::If},
      {"ELSEIF", Flow::ElseIf},  // before ELSE
      {"ELSE", Flow::Else},
      {"ENDIF", Flow::EndIf},
      {"BREAK", Flow::Break},
      {"CONTINUE", Flow::Continue},
      {"REPEAT", Flow::Repeat},
      {"ENDREPEAT", Flow::EndRepeat},
  }};
  OWord word;
  text.remove_prefix(1);
  const std::string_view digits = digitsOf(text);
  const auto closing = text.starts_with('<') ? text.find('>') : text.npos;
  if (closing != text.npos) {
    word.label = text.substr(1, closing - 1);
    text.remove_prefix(closing + 1);
  } else if (!digits.empty()) {
    word.label = labelOf(digits);
    text.remove_prefix(digits.size());
  } else if (text.starts_with('[')) {
    const auto call = text.rfind("]CALL");
    if (call == text.npos) {
      return fail(ErrorCode::Unsupported,
                  "O is followed by an expression, which only a call may have");
    }
    const auto end = [&] {  // of the brackets at its begin
      int depth = 0;
      for (std::size_t i = 0; i < text.size(); ++i) {
        depth += text[i] == '[' ? 1 : text[i] == ']' ? -1 : 0;
        if (depth == 0) return i + 1;
      }
      return text.size();
    }();
    word.label = text.substr(0, end);
    text.remove_prefix(end);
  } else {
    return fail(ErrorCode::Unsupported,
                fmt::format("O is followed by {}, expected a number or <name>", inQuotes(text)));
  }
  const auto found = std::ranges::find_if(
      kWords, [&](const auto& known) { return text.starts_with(known.first); });
  if (found != kWords.end()) {
    word.flow = found->second;
    text.remove_prefix(found->first.size());
  }
  word.rest = text;
  return word;
}

/// WHILE [..] DO 1, END 1, IF [..] and GOTO of Fanuc's controls; nothing if the text is none.
std::optional<GcodeProgram::OWord> GcodeProgram::macroOf(std::string_view text) {
  const auto wordOf = [](Flow flow, std::string label, std::string_view rest) {
    OWord word;
    word.flow = flow;
    word.label = std::move(label);
    word.rest = rest;
    return word;
  };
  if (text.starts_with("WHILE[")) {
    const auto at = text.rfind("]DO");
    if (at == text.npos) return std::nullopt;
    return wordOf(Flow::While, "DO " + labelOf(text.substr(at + 3)), text.substr(5, at - 4));
  }
  if (text.starts_with("END") && text.size() > 3 && digitsOf(text.substr(3)) == text.substr(3)) {
    return wordOf(Flow::EndWhile, "DO " + labelOf(text.substr(3)), {});
  }
  if (text.starts_with("IF[")) return wordOf(Flow::IfThen, {}, text.substr(2));
  if (text.starts_with("GOTO")) return wordOf(Flow::GoTo, {}, text.substr(4));
  return std::nullopt;
}

Result<void> GcodeProgram::findOWords() {
  constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  std::size_t part = kNone;  // the last line O100
  for (at_ = 0; at_ < lines_.size(); ++at_) {
    if (lines_[at_].find_first_of("OoMmNnWwIiGg") == std::string_view::npos) continue;
    if (auto read = readLine(part); !read) return read;
  }
  if (open_.empty()) return {};
  at_ = open_.back();
  return invalid(fmt::format("{} begins here and has no end", oWordName(oWords_.at(at_).label)));
}

/// What is wrong in a line is said when it is carried out.
Result<void> GcodeProgram::readLine(std::size_t& part) {
  const auto text = gcodeText(lines_[at_]);
  if (!text || text->starts_with('%')) return {};
  bool isOptional = false;
  std::string_view number;
  const std::string_view words = withoutNumber(*text, isOptional, number);
  if (!number.empty()) numbers_[labelOf(number)].push_back(at_);
  const bool inPart = part < lines_.size();
  if (inPart && hasM(words, 99)) ends_[part] = at_;
  if (inPart && (hasM(words, 2) || hasM(words, 30))) ends_.erase(part);
  if (auto macro = macroOf(words)) {
    if (auto joined = join(*macro); !joined) return joined;
    oWords_.emplace(at_, std::move(*macro));
    return {};
  }
  if (!words.starts_with('O')) return {};
  auto word = oWordOf(words);
  if (!word) return word.error();
  if (word->flow == Flow::Name) part = at_;
  if (auto joined = join(*word); !joined) return joined;
  oWords_.emplace(at_, std::move(*word));
  return {};
}

Result<void> GcodeProgram::define(std::map<std::string, std::size_t>& names, const OWord& word) {
  const auto [at, isNew] = names.emplace(word.label, at_);
  if (isNew) return {};
  return invalid(fmt::format("{} is a second subprogram of this name; the first is in line {}",
                             oWordName(word.label), at->second + 1));
}

/// Joins a word with those of its block that have been read.
Result<void> GcodeProgram::join(OWord& word) {
  switch (word.flow) {
    case Flow::Name:
      return define(names_, word);
    case Flow::Call:
    case Flow::Return:
    case Flow::IfThen:
    case Flow::GoTo:
      return {};
    case Flow::Break:
    case Flow::Continue:
      return joinJump(word);
    case Flow::Sub:
      if (auto defined = define(subs_, word); !defined) return defined;
      break;
    case Flow::While: {
      const OWord* last = open_.empty() ? nullptr : &oWords_.at(open_.back());
      if (last == nullptr || last->flow != Flow::Do || last->label != word.label) break;
      word.flow = Flow::WhileOfDo;
      return joinEnd(word);
    }
    case Flow::Do:
    case Flow::If:
    case Flow::Repeat:
      break;
    default:
      return joinEnd(word);
  }
  open_.push_back(at_);
  return {};
}

Result<void> GcodeProgram::joinJump(OWord& word) {
  const auto loop = std::find_if(open_.rbegin(), open_.rend(), [&](std::size_t line) {
    const OWord& one = oWords_.at(line);
    return one.label == word.label && one.flow != Flow::If && one.flow != Flow::Sub;
  });
  if (loop == open_.rend()) {
    return invalid(fmt::format("{}: there is no loop of this name here", oWordName(word.label)));
  }
  word.other = *loop;
  return {};
}

Result<void> GcodeProgram::joinEnd(OWord& word) {
  const auto beginOf = [](Flow end) {
    switch (end) {
      case Flow::EndSub:
        return Flow::Sub;
      case Flow::WhileOfDo:
        return Flow::Do;
      case Flow::EndWhile:
        return Flow::While;
      case Flow::EndRepeat:
        return Flow::Repeat;
      default:
        return Flow::If;
    }
  };
  OWord* begin = open_.empty() ? nullptr : &oWords_.at(open_.back());
  if (begin == nullptr || begin->label != word.label || begin->flow != beginOf(word.flow)) {
    return invalid(fmt::format(
        "{} ends or goes on here without its beginning; {}", oWordName(word.label),
        begin == nullptr
            ? "no block is open"
            : fmt::format("open is {}, from line {}", oWordName(begin->label), open_.back() + 1)));
  }
  word.other = open_.back();
  begin->other = at_;
  if (begin->flow == Flow::If) begin->branches.push_back(at_);
  if (word.flow != Flow::ElseIf && word.flow != Flow::Else) open_.pop_back();
  return {};
}

Result<void> GcodeProgram::runLine() {
  const auto text = gcodeText(lines_[at_]);
  if (!text) return text.error();
  if (text->starts_with('%')) {
    ended_ = begun_;  // the second one ends the program
    begun_ = true;
    return {};
  }
  if (text->starts_with('$')) return {};  // what GRBL is told of itself: $H, $X
  bool isOptional = false;
  const std::string_view words = withoutNumber(*text, isOptional);
  if (isOptional) ++optionalLines_;
  const auto word = oWords_.find(at_);
  return word == oWords_.end() ? runBlock(words) : follow(word->second);
}

Result<void> GcodeProgram::runBlock(std::string_view text) {
  const auto block = readGcodeBlock(text, dialect_, parameters_);
  if (!block) return block.error();
  if (auto applied = apply_(*block, line(), calls_.size() - 1); !applied) return applied;
  if (block->calls) return callNumbered(*block);
  if (block->returns) return leaveNumbered();
  ended_ = block->ends;
  return {};
}

Result<void> GcodeProgram::follow(const OWord& word) {
  const auto jumpUnless = [&](std::size_t line, bool wanted) -> Result<void> {
    const auto holds = conditionOf(word);
    if (!holds) return holds.error();
    if ((*holds != 0) != wanted) next_ = line;
    return {};
  };
  switch (word.flow) {
    case Flow::Name:
      // A subprogram is for calls.
      if (const auto end = ends_.find(at_); end != ends_.end()) next_ = end->second + 1;
      return ends_.contains(at_) ? Result<void>() : runBlock(word.rest);
    case Flow::Sub:
      next_ = word.other + 1;
      return {};
    case Flow::Call:
      return call(word);
    case Flow::Return:
    case Flow::EndSub:
      return leave(word);
    case Flow::If:
      return chooseBranch(word);
    case Flow::ElseIf:
    case Flow::Else:
      next_ = oWords_.at(word.other).branches.back() + 1;  // from the branch before
      return {};
    case Flow::While:
      return jumpUnless(word.other + 1, true);
    case Flow::WhileOfDo:
      return jumpUnless(word.other + 1, false);
    case Flow::EndWhile:
      next_ = word.other;
      return {};
    case Flow::Repeat:
      return beginRepeats(word);
    case Flow::EndRepeat:
      endRepeat(word);
      return {};
    case Flow::IfThen:
      return ifThen(word.rest);
    case Flow::GoTo: {
      GcodeWords words(word.rest, parameters_);
      return goTo(words);
    }
    case Flow::Break:
      next_ = oWords_.at(word.other).other + 1;
      return {};
    case Flow::Continue:
      next_ = oWords_.at(word.other).other;
      return {};
    case Flow::Do:
    case Flow::EndIf:
      return {};
  }
  return {};
}

Result<double> GcodeProgram::conditionOf(const OWord& word) {
  GcodeWords words(word.rest, parameters_);
  auto value = words.bracketed();
  if (value && !words.atEnd()) {
    return invalid(fmt::format("found {} after the condition", inQuotes(words.rest())));
  }
  return value;
}

/// IF [..] GOTO 10, IF [..] THEN #1 = 2.
Result<void> GcodeProgram::ifThen(std::string_view text) {
  GcodeWords words(text, parameters_);
  const auto holds = words.bracketed();
  if (!holds) return holds.error();
  if (words.skip("GOTO")) return *holds != 0 ? goTo(words) : Result<void>();
  if (words.skip("THEN")) return *holds != 0 ? runBlock(words.rest()) : Result<void>();
  return invalid(
      fmt::format("found {} after the condition, expected GOTO or THEN", inQuotes(words.rest())));
}

/// To the next line with this N, or else the first one.
Result<void> GcodeProgram::goTo(GcodeWords& words) {
  const auto number = words.expression();
  if (!number) return number.error();
  const auto found = numbers_.find(fmt::format("{:.10g}", *number));
  if (!words.atEnd() || found == numbers_.end()) {
    return invalid(fmt::format("GOTO {0:.10g}: no line has N{0:.10g}", *number));
  }
  const auto next = std::ranges::upper_bound(found->second, at_);
  next_ = next == found->second.end() ? found->second.front() : *next;
  return {};
}

/// To the first branch of which the condition holds.
Result<void> GcodeProgram::chooseBranch(const OWord& begin) {
  const auto holds = conditionOf(begin);
  if (!holds) return holds.error();
  if (*holds != 0) return {};
  for (const std::size_t line : begin.branches) {
    at_ = line;
    next_ = line + 1;
    const OWord& branch = oWords_.at(line);
    if (branch.flow != Flow::ElseIf) return {};
    const auto chosen = conditionOf(branch);
    if (!chosen) return chosen.error();
    if (*chosen != 0) return {};
  }
  return {};
}

Result<void> GcodeProgram::beginRepeats(const OWord& word) {
  const auto count = conditionOf(word);
  if (!count) return count.error();
  calls_.back().repeats[at_] = *count;
  if (!(*count >= 1)) next_ = word.other + 1;
  return {};
}

void GcodeProgram::endRepeat(const OWord& word) {
  if (--calls_.back().repeats[word.other] >= 1) next_ = word.other + 1;
}

Result<void> GcodeProgram::enter(std::size_t begin, double times) {
  if (calls_.size() > kDeepestCall) {
    return fail(ErrorCode::Unsupported,
                fmt::format("subprograms call each other more than {} deep", kDeepestCall));
  }
  calls_.push_back({.from = at_, .begin = begin, .left = times});
  next_ = begin + 1;
  return {};
}

Result<void> GcodeProgram::call(const OWord& word) {
  std::string label = word.label;
  if (label.starts_with('[')) {
    GcodeWords words(label, parameters_);
    const auto number = words.bracketed();
    if (!number) return number.error();
    label = fmt::format("{:.10g}", *number);
  }
  const auto sub = subs_.find(label);
  if (sub == subs_.end()) {
    return fail(ErrorCode::Unsupported,
                fmt::format("{0} is called, and the file has no {0} sub; put the subprogram into "
                            "it",
                            oWordName(label)));
  }
  std::map<int, double> arguments;
  GcodeWords words(word.rest, parameters_);
  while (!words.atEnd()) {
    const auto argument = words.bracketed();
    if (!argument) return argument.error();
    if (arguments.size() == GcodeParameters::kArguments) {
      return invalid(fmt::format("a call has more than {} arguments", GcodeParameters::kArguments));
    }
    arguments.emplace(static_cast<int>(arguments.size()) + 1, *argument);
  }
  if (auto entered = enter(sub->second, 0); !entered) return entered;
  parameters_.enter(std::move(arguments));
  return {};
}

Result<void> GcodeProgram::leave(const OWord& word) {
  if (calls_.size() < 2 || calls_.back().left > 0) {
    return invalid(fmt::format("{}: a subprogram ends that was not called", oWordName(word.label)));
  }
  double value = 0;
  if (!word.rest.empty()) {
    const auto given = conditionOf(word);
    if (!given) return given.error();
    value = *given;
  }
  parameters_.leave();
  next_ = calls_.back().from + 1;
  calls_.pop_back();
  if (auto set = parameters_.set("_VALUE", value); !set) return set;
  return parameters_.set("_VALUE_RETURNED", word.rest.empty() ? 0 : 1);
}

/// Where the subprogram of M97, M98 or G65 begins, and how often it comes.
Result<std::pair<std::size_t, double>> GcodeProgram::numberedSub(const GcodeBlock& block) const {
  const std::string_view caller = block.isMacro ? "G65" : block.isLocal ? "M97" : "M98";
  if (!block.p) return invalid(fmt::format("{} has no P, the number of the subprogram", caller));
  const double times = block.l.value_or(1);
  const std::string number = fmt::format("{:.10g}", *block.p);
  if (block.isLocal) {
    const auto lines = numbers_.find(number);
    if (lines != numbers_.end()) return std::pair(lines->second.front() - 1, times);
    return invalid(fmt::format("M97 calls P{0}, and no line has N{0}", number));
  }
  if (const auto name = names_.find(number); name != names_.end()) {
    return std::pair(name->second, times);
  }
  // P30100 of older controls is O0100 three times.
  constexpr double kNumbers = 10'000;
  if (*block.p >= kNumbers && !block.l) {
    const auto name = names_.find(fmt::format("{:.10g}", std::fmod(*block.p, kNumbers)));
    if (name != names_.end()) return std::pair(name->second, std::floor(*block.p / kNumbers));
  }
  return invalid(
      fmt::format("{0} calls P{1}, and no line O{1} begins a subprogram; repeats are given by L",
                  caller, number));
}

Result<void> GcodeProgram::callNumbered(const GcodeBlock& block) {
  const auto sub = numberedSub(block);
  if (!sub) return sub.error();
  const auto [begin, times] = *sub;
  if (!(times >= 1)) return {};
  if (auto entered = enter(begin, times); !entered) return entered;
  calls_.back().isMacro = block.isMacro;
  if (block.isMacro) parameters_.enter(argumentsOf(block));
  return {};
}

Result<void> GcodeProgram::leaveNumbered() {
  if (calls_.size() < 2) {
    repeatsForEver_ = ended_ = true;
    return {};
  }
  Called& called = calls_.back();
  if (!(called.left > 0)) return invalid("M99 stands in a subprogram that M98 did not call");
  if (--called.left >= 1) {
    next_ = called.begin + 1;
    return {};
  }
  next_ = called.from + 1;
  if (called.isMacro) parameters_.leave();
  calls_.pop_back();
  return {};
}

}  // namespace t4d::formats
