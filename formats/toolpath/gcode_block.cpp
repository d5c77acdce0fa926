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

constexpr auto kGCodes = std::to_array<KnownCode>({
    {0, Motion},
    {10, Motion},
    {20, Motion},
    {30, Motion},
    {50, Motion},
    {51, Motion},
    {52, Motion},
    {53, Motion},
    {330, Motion},
    {331, Motion},
    {730, Motion},
    {740, Motion},
    {810, Motion},
    {820, Motion},
    {830, Motion},
    {840, Motion},
    {850, Motion},
    {860, Motion},
    {890, Motion},
    {800, Cancel},
    {40, NonModal},
    {100, NonModal},
    {280, NonModal},
    {281, NonModal},
    {300, NonModal},
    {301, NonModal},
    {520, NonModal},
    {530, NonModal},
    {920, NonModal},
    {921, NonModal},
    {922, NonModal},
    {923, NonModal},
    {170, Plane},
    {180, Plane},
    {190, Plane},
    {200, Units},
    {210, Units},
    {900, Distance},
    {910, Distance},
    {901, Centres},
    {911, Centres},
    {540, Origin},
    {550, Origin},
    {560, Origin},
    {570, Origin},
    {580, Origin},
    {590, Origin},
    {591, Origin},
    {592, Origin},
    {593, Origin},
    {930, FeedMode},
    {940, FeedMode},
    {950, FeedMode},
    {980, Retract},
    {990, Retract},
    {430, ToolLength},
    {431, ToolLength},
    {432, ToolLength},
    {434, ToolLength},
    {490, ToolLength},
    {610, Path},
    {611, Path},
    {640, Path},
    {400, Compensation},
    {410, Compensation},
    {411, Compensation},
    {420, Compensation},
    {421, Compensation},
    {150, Polar},
    {160, Polar},
    {500, Scale},
    {510, Scale},
    {501, Mirror},
    {511, Mirror},
    {690, Rotation},
    {680, Rotation},
    // The spindle, exact stops, and ends of what is not supported.
    {80, Harmless},
    {90, Harmless},
    {131, Harmless},
    {220, Harmless},
    {230, Harmless},
    {250, Harmless},
    {260, Harmless},
    {401, Harmless},
    {502, Harmless},
    {670, Harmless},
    {960, Harmless},
    {970, Harmless},
    {1030, Harmless},
    {1130, Harmless},
    {1870, Harmless},
});

// What moves no axis: the spindle, coolant, clamps (10, 11), chips, gears, overrides, inputs and
// outputs, and the fan of M107.
constexpr auto kHarmlessM = std::to_array<int>(
    {0,  1,  3,  4,  5,  7,  8,  9,  10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22,
     23, 24, 25, 29, 31, 32, 33, 34, 35, 36, 40, 41, 42, 43, 44, 45, 48, 49, 50, 51, 52,
     53, 60, 62, 63, 64, 65, 66, 67, 68, 69, 78, 79, 82, 83, 84, 85, 86, 88, 89, 107});

constexpr std::string_view kUnknown =
    "not among the words that are known; take it out if it moves nothing";

constexpr std::array<std::string_view, 4> kMacroWords = {"IF[", "WHILE[", "GOTO", "END"};

/// What a G word is that is not read, and what to do about it.
std::string_view meaningOf(int tenths) {
  switch (tenths) {
    case 60:
    case 61:
    case 62:
      return "a spline with knots; have lines and arcs written";
    case 541:
    case 1540:
      return "one of more than nine origins; have G54 to G59.3 written";
    case 660:
      return "a macro that every line after it calls; have plain moves written, or G65";
    case 70:
      return "the diameter mode of lathes";
    case 120:
    case 130:
      return "a circular pocket of Haas's controls; have its moves written";
    case 121:
    case 71:
    case 1120:
      return "polar interpolation, after which X and C are not what they were; have the moves of X "
             "and Y written";
    case 760:
      return "a thread cut with a synchronized spindle; have its moves written";
    case 382:
    case 383:
    case 384:
    case 385:
      return "probing, whose result is not known here";
    case 700:
    case 710:
      return "inches or millimetres on controls of Siemens (--dialect siemens), and a cycle of "
             "lathes on others";
    case 711:
    case 712:
    case 720:
    case 721:
    case 722:
      return "a cycle of lathes; have its moves written";
    case 682:
      return "a turned plane of work; have its moves in the frame of the part written, with "
             "G43.4";
    case 870:
    case 880:
      return "a boring cycle that needs an operator; have its moves written";
    case 1500:
      return "a pocket of Haas's controls; have its moves written";
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

/// The G word that means what one of Siemens' means.
int ofSiemens(int code) {
  switch (code) {
    case 700:
    case 7000:
      return 200;
    case 710:
    case 7100:
      return 210;
    default:
      return code;
  }
}

class BlockReader {
 public:
  BlockReader(std::string_view text, GcodeDialect dialect, GcodeParameters& parameters)
      : words_(text, parameters), dialect_(dialect), parameters_(parameters) {}

  Result<GcodeBlock> read() {
    while (!words_.atEnd()) {
      auto done = words_.skip("#") ? readAssignment() : readWord();
      if (!done) return done.error();
    }
    auto& motion = block_.codes[static_cast<std::size_t>(Motion)];
    if ((motion == 50 || motion == 51) && !block_.hasAxes()) {  // smoothing of Fanuc's
      motion.reset();
      block_.talks = true;
    }
    if (auto good = checkLetters(); !good) return good.error();
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
    const auto value = words_.expression();
    if (!value) return value.error();
    assignments_.emplace_back(std::move(*which), *value);
    return {};
  }

  /// Of letters that stand for nothing but an argument of a macro (G65).
  Result<void> checkLetters() const {
    if (block_.isMacro) return {};
    for (const char letter : std::string_view("EUVW")) {
      const auto& value = block_.arguments[static_cast<std::size_t>(letter - 'A')];
      const bool waits = letter == 'U' && block_.code(NonModal) == 40;
      const bool talks = letter == 'E' && block_.talks;
      if (value && !waits && !talks) {
        return unsupported(fmt::format("{}{:g}", letter, *value), meaningOf(letter));
      }
    }
    return {};
  }

  Result<void> readWord() {
    const char letter = words_.rest()[0];
    for (const std::string_view macro : kMacroWords) {
      if (!words_.rest().starts_with(macro)) continue;
      return invalid(
          fmt::format("{} stands in a line behind other words", macro.substr(0, macro.find('['))));
    }
    if (words_.skip("CR=")) return readInto(block_.r, "CR=");
    if (words_.skip(",R")) return readInto(block_.corner, ",R");
    if (words_.skip(",C")) return readInto(block_.chamfer, ",C");
    if (letter != '@' && letter != '^' && (letter < 'A' || letter > 'Z')) {
      return invalid(fmt::format("found {}, expected a letter", inQuotes(words_.rest())));
    }
    words_.skip(words_.rest().substr(0, 1));
    const std::string_view before = words_.rest();
    const auto value = readNumber(std::string_view(&letter, 1));
    if (!value) return value.error();
    const std::string_view digits = before.substr(0, before.size() - words_.rest().size());
    if (digits.find_first_not_of("+-0123456789") == digits.npos) block_.markWhole(letter);
    return take(letter, *value);
  }

  Result<double> readNumber(std::string_view word) {
    if (!words_.startsNumber()) {
      return invalid(words_.atEnd() ? fmt::format("{} stands without a number", word)
                                    : fmt::format("{} is followed by {}, expected a number", word,
                                                  inQuotes(words_.rest())));
    }
    auto value = words_.number();
    constexpr double kLargest = 1e9;
    if (value && std::abs(*value) > kLargest) {
      return invalid(fmt::format("{} is followed by {:g}, but at most {:g} is possible", word,
                                 *value, kLargest));
    }
    return value;
  }

  Result<void> readInto(std::optional<double>& into, std::string_view word) {
    const auto value = readNumber(word);
    return value ? set(into, word, *value) : Result<void>(value.error());
  }

  static Result<void> set(std::optional<double>& into, std::string_view word, double value) {
    if (into) {
      return invalid(fmt::format("{}{:g}: this letter comes twice in the line", word, value));
    }
    into = value;
    return {};
  }

  Result<void> take(char letter, double value) {
    const std::string_view word(&letter, 1);
    if (letter == 'G') return takeG(value);
    if (letter == 'M') return takeM(value);
    if (letter == '@') return set(block_.radius, word, value);
    if (letter == '^') return set(block_.angle, word, value);
    if (letter != 'N' && letter != 'S' && letter != 'D') {
      auto good = set(block_.arguments[static_cast<std::size_t>(letter - 'A')], word, value);
      if (!good) return good;
    } else {
      block_.arguments[static_cast<std::size_t>(letter - 'A')] = value;
    }
    std::optional<double>* into = fieldOf(letter);
    if (into != nullptr) *into = value;
    if (into != nullptr || std::string_view("EUVWN").find(letter) != std::string_view::npos) {
      return {};
    }
    return unsupported(fmt::format("{}{:g}", letter, value), meaningOf(letter));
  }

  std::optional<double>* fieldOf(char letter) {
    const auto at = [&](char first) { return static_cast<std::size_t>(letter - first); };
    switch (letter) {
      case 'X':
      case 'Y':
      case 'Z':
        return &block_.axes[at('X')];
      case 'A':
      case 'B':
      case 'C':
        return &block_.axes[3 + at('A')];
      case 'I':
      case 'J':
      case 'K':
        return &block_.centre[at('I')];
      case 'D':
        return &block_.d;
      case 'F':
        return &block_.f;
      case 'H':
        return &block_.h;
      case 'L':
        return &block_.l;
      case 'P':
        return &block_.p;
      case 'Q':
        return &block_.q;
      case 'R':
        return &block_.r;
      case 'S':
        return &block_.s;
      case 'T':
        return &block_.t;
      case 'U':
        return &block_.dwell;
      default:
        return nullptr;
    }
  }

  Result<void> takeG(double value) {
    int code = tenthsOf(value);
    if (dialect_ == GcodeDialect::Siemens) code = ofSiemens(code);
    if (code == 650) {
      block_.calls = block_.isMacro = true;
      return {};
    }
    const auto known = std::ranges::find(kGCodes, code, &KnownCode::tenths);
    if (known == kGCodes.end()) return unsupported(fmt::format("G{:g}", value), meaningOf(code));
    auto& before = block_.codes[static_cast<std::size_t>(known->group)];
    if (before && known->group != Harmless) {
      return invalid(fmt::format("{}: another word in the line says the same or the opposite",
                                 gcodeWord(code)));
    }
    before = code;
    block_.talks = block_.talks || known->group == Harmless;
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
    } else if (code == 97) {
      block_.calls = block_.isLocal = true;
    } else if (code >= 70 && code <= 73) {
      block_.saves = code;
    } else if (code == 99) {
      block_.returns = true;
    } else if (std::ranges::find(kHarmlessM, code) == kHarmlessM.end()) {
      return unsupported(fmt::format("M{:g}", value), kUnknown);
    } else {
      block_.talks = true;
    }
    return {};
  }

  GcodeWords words_;
  GcodeDialect dialect_;
  GcodeParameters& parameters_;
  GcodeBlock block_;
  std::vector<std::pair<GcodeWords::Parameter, double>> assignments_;
};

}  // namespace

bool GcodeBlock::hasAxes() const {
  return radius || angle ||
         std::ranges::any_of(axes, [](const auto& value) { return value.has_value(); });
}

bool GcodeBlock::isWhole(char letter) const {
  return letter >= 'A' && letter <= 'Z' && (whole >> (letter - 'A') & 1U) != 0;
}

void GcodeBlock::markWhole(char letter) {
  if (letter >= 'A' && letter <= 'Z') whole |= 1U << (letter - 'A');
}

std::string gcodeWord(int tenths) {
  return tenths % 10 == 0 ? fmt::format("G{}", tenths / 10)
                          : fmt::format("G{}.{}", tenths / 10, tenths % 10);
}

Result<GcodeBlock> readGcodeBlock(std::string_view text, GcodeDialect dialect,
                                  GcodeParameters& parameters) {
  return BlockReader(text, dialect, parameters).read();
}

}  // namespace t4d::formats
