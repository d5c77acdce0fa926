#include "formats/toolpath/gcode_block.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "formats/text/text_scanner.h"

namespace t4d::formats {
namespace {

struct KnownCode {
  int tenths;
  GcodeGroup group;
};

using enum GcodeGroup;

constexpr std::array<KnownCode, 59> kGCodes = {{
    {0, Motion},       {10, Motion},      {20, Motion},      {30, Motion},      {730, Motion},
    {740, Motion},     {810, Motion},     {820, Motion},     {830, Motion},     {840, Motion},
    {850, Motion},     {860, Motion},     {890, Motion},     {800, Cancel},     {40, NonModal},
    {100, NonModal},   {280, NonModal},   {281, NonModal},   {300, NonModal},   {301, NonModal},
    {520, NonModal},   {530, NonModal},   {920, NonModal},   {921, NonModal},   {922, NonModal},
    {923, NonModal},   {170, Plane},      {180, Plane},      {190, Plane},      {200, Units},
    {210, Units},      {900, Distance},   {910, Distance},   {901, Centres},    {911, Centres},
    {540, Origin},     {550, Origin},     {560, Origin},     {570, Origin},     {580, Origin},
    {590, Origin},     {591, Origin},     {592, Origin},     {593, Origin},     {930, FeedMode},
    {940, FeedMode},   {980, Retract},    {990, Retract},    {430, ToolLength}, {431, ToolLength},
    {432, ToolLength}, {434, ToolLength}, {490, ToolLength}, {610, Path},       {611, Path},
    {640, Path},       {80, Harmless},    {400, Harmless},   {970, Harmless},
}};

// 10, 11: clamps of rotary axes; 29: rigid tapping.
constexpr std::array<int, 19> kHarmlessM = {0,  1,  3,  4,  5,  7,  8,  9,  10, 11,
                                            19, 29, 48, 49, 50, 51, 52, 53, 60};

constexpr std::string_view kUnknown =
    "not among the words that are known; take it out if it moves nothing";

constexpr std::array<std::string_view, 4> kMacroWords = {"IF[", "WHILE[", "GOTO", "END"};

/// What a G word is that is not read, and what to do about it.
std::string_view meaningOf(int tenths) {
  switch (tenths) {
    case 50:
    case 51:
    case 52:
      return "a spline, or smoothing on other controls; have lines and arcs written, without it";
    case 541:
    case 1540:
      return "one of more than nine origins; have G54 to G59.3 written";
    case 650:
    case 660:
      return "a call of a macro; have plain moves written";
    case 70:
      return "the diameter mode of lathes";
    case 330:
    case 331:
    case 760:
      return "a thread cut with a synchronized spindle; have its moves written";
    case 382:
    case 383:
    case 384:
    case 385:
      return "probing, whose result is not known here";
    case 410:
    case 420:
      return "cutter compensation; have the path of the tool's centre written";
    case 510:
    case 680:
    case 682:
      return "a scaled or turned program; have plain coordinates written";
    case 870:
    case 880:
      return "a boring cycle that needs an operator; have its moves written";
    case 950:
      return "feed per turn; have feed per minute written (G94)";
    case 960:
      return "a constant cutting speed, which lathes have";
    default:
      return kUnknown;
  }
}

std::string_view meaningOf(char letter) {
  switch (letter) {
    case 'U':
    case 'V':
    case 'W':
      return "a second linear axis";
    case 'E':
      return "the filament of a 3D printer, or an exponent; have plain decimal numbers written";
    case '@':
    case '^':
      return "a polar coordinate; have X and Y written";
    default:
      return kUnknown;
  }
}

Error unsupported(const std::string& word, std::string_view meaning) {
  return fail(ErrorCode::Unsupported, fmt::format("{} is not supported: it is {}", word, meaning));
}

/// A G or M word, in tenths; -1 if it has more decimals.
int tenthsOf(double value) {
  const double tenths = 10 * value;
  const bool whole = tenths >= 0 && tenths < 10'000 && std::abs(tenths - std::round(tenths)) < 1e-6;
  return whole ? static_cast<int>(std::round(tenths)) : -1;
}

class BlockReader {
 public:
  BlockReader(std::string_view text, GcodeParameters& parameters)
      : words_(text, parameters), parameters_(parameters) {}

  Result<GcodeBlock> read() {
    while (!words_.atEnd()) {
      auto done = words_.skip("#") ? readAssignment() : readWord();
      if (!done) return done.error();
    }
    for (const auto& [which, value] : assignments_) {
      auto done = which.name.empty() ? parameters_.set(which.number, value)
                                     : parameters_.set(which.name, value);
      if (!done) return done.error();
    }
    return block_;
  }

 private:
  Result<void> readAssignment() {
    auto which = words_.parameter();
    if (!which) return which.error();
    if (!words_.skip("=")) {
      return invalid("a parameter stands without a letter before it or = after it");
    }
    const auto value = words_.number();
    if (!value) return value.error();
    assignments_.emplace_back(std::move(*which), *value);
    return {};
  }

  Result<void> readWord() {
    const char letter = words_.rest()[0];
    if (letter == '@' || letter == '^') {
      return unsupported(std::string(1, letter), meaningOf(letter));
    }
    for (const std::string_view macro : kMacroWords) {
      if (!words_.rest().starts_with(macro)) continue;
      return unsupported(
          std::string(macro.substr(0, macro.find('['))),
          "a macro of Fanuc's controls; have plain moves or O-words (o1 if) written");
    }
    if (!assignments_.empty() && std::string_view("+-*/").find(letter) != std::string_view::npos) {
      return invalid(
          fmt::format("found {} after a value; expressions stand in square brackets, as "
                      "in #1=[#2+1]",
                      inQuotes(words_.rest())));
    }
    if (letter < 'A' || letter > 'Z') {
      return invalid(fmt::format("found {}, expected a letter", inQuotes(words_.rest())));
    }
    words_.skip(words_.rest().substr(0, 1));
    if (!words_.startsNumber()) {
      return invalid(words_.atEnd() ? fmt::format("{} stands without a number", letter)
                                    : fmt::format("{} is followed by {}, expected a number", letter,
                                                  inQuotes(words_.rest())));
    }
    const auto value = words_.number();
    if (!value) return value.error();
    constexpr double kLargest = 1e9;
    if (std::abs(*value) > kLargest) {
      return invalid(fmt::format("{} is followed by {:g}, but at most {:g} is possible", letter,
                                 *value, kLargest));
    }
    return take(letter, *value);
  }

  Result<void> take(char letter, double value) {
    const auto set = [&](std::optional<double>& into) -> Result<void> {
      if (into) {
        return invalid(fmt::format("{}{:g}: this letter comes twice in the line", letter, value));
      }
      into = value;
      return {};
    };
    switch (letter) {
      case 'G':
        return takeG(value);
      case 'M':
        return takeM(value);
      case 'X':
      case 'Y':
      case 'Z':
        return set(block_.axes[static_cast<std::size_t>(letter - 'X')]);
      case 'A':
      case 'B':
      case 'C':
        return set(block_.axes[static_cast<std::size_t>(3 + letter - 'A')]);
      case 'I':
      case 'J':
      case 'K':
        return set(block_.centre[static_cast<std::size_t>(letter - 'I')]);
      case 'F':
        return set(block_.f);
      case 'H':
        return set(block_.h);
      case 'L':
        return set(block_.l);
      case 'P':
        return set(block_.p);
      case 'Q':
        return set(block_.q);
      case 'R':
        return set(block_.r);
      case 'T':
        return set(block_.t);
      case 'S':
      case 'N':
      case 'D':
        return {};
      default:
        return unsupported(fmt::format("{}{:g}", letter, value), meaningOf(letter));
    }
  }

  Result<void> takeG(double value) {
    const int code = tenthsOf(value);
    const auto known = std::ranges::find(kGCodes, code, &KnownCode::tenths);
    if (known == kGCodes.end()) return unsupported(fmt::format("G{:g}", value), meaningOf(code));
    auto& before = block_.codes[static_cast<std::size_t>(known->group)];
    if (before && known->group != Harmless) {
      return invalid(fmt::format("{}: another word in the line says the same or the opposite",
                                 gcodeWord(code)));
    }
    before = code;
    return {};
  }

  Result<void> takeM(double value) {
    const int tenths = tenthsOf(value);
    const int code = tenths >= 0 && tenths % 10 == 0 ? tenths / 10 : -1;
    if (code == 2 || code == 30) {
      block_.ends = true;
    } else if (code == 6) {
      block_.changesTool = true;
    } else if (code == 61) {
      block_.namesTool = true;
    } else if (code == 98) {
      block_.calls = true;
    } else if (code == 99) {
      block_.returns = true;
    } else if (std::ranges::find(kHarmlessM, code) == kHarmlessM.end()) {
      return unsupported(fmt::format("M{:g}", value), kUnknown);
    }
    return {};
  }

  GcodeWords words_;
  GcodeParameters& parameters_;
  GcodeBlock block_;
  std::vector<std::pair<GcodeWords::Parameter, double>> assignments_;
};

}  // namespace

bool GcodeBlock::hasAxes() const {
  return std::ranges::any_of(axes, [](const auto& value) { return value.has_value(); });
}

std::string gcodeWord(int tenths) {
  return tenths % 10 == 0 ? fmt::format("G{}", tenths / 10)
                          : fmt::format("G{}.{}", tenths / 10, tenths % 10);
}

Result<GcodeBlock> readGcodeBlock(std::string_view text, GcodeParameters& parameters) {
  return BlockReader(text, parameters).read();
}

}  // namespace t4d::formats
