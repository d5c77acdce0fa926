#include "formats/toolpath/gcode_dialect.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "formats/toolpath/gcode_words.h"
#include "model/number.h"

namespace t4d::formats {
namespace {

constexpr std::array<std::pair<std::string_view, GcodeDialect>, 6> kNames = {{
    {"linuxcnc", GcodeDialect::LinuxCnc},
    {"grbl", GcodeDialect::Grbl},
    {"fanuc", GcodeDialect::Fanuc},
    {"haas", GcodeDialect::Haas},
    {"mach3", GcodeDialect::Mach3},
    {"siemens", GcodeDialect::Siemens},
}};

/// What a first reading of a program finds.
struct Looks {
  bool percent = false;
  bool named = false;   // O and a number, alone, before any other line
  bool oWords = false;  // of LinuxCNC
  bool points = false;  // in coordinates
  double largest = 0;   // coordinate
};

void look(std::string_view text, bool isFirst, Looks& looks) {
  if (text.starts_with('O')) {
    const auto end = std::min(text.find_first_not_of("0123456789", 1), text.size());
    const bool alone = end == text.size() && end > 1;
    looks.named = looks.named || (alone && isFirst);
    looks.oWords = looks.oWords || !alone;
    return;
  }
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (std::string_view("XYZIJKR").find(text[at]) == std::string_view::npos) continue;
    std::string_view rest = text.substr(at + 1);
    const auto digits = std::min(rest.find_first_not_of("+-0123456789."), rest.size());
    rest = rest.substr(0, digits);
    if (rest.empty()) continue;
    looks.points = looks.points || rest.find('.') != rest.npos;
    if (rest.starts_with('+')) rest.remove_prefix(1);
    if (const auto value = model::takeNumber<double>(rest, std::chars_format::fixed)) {
      looks.largest = std::max(looks.largest, std::abs(*value));
    }
  }
}

}  // namespace

std::optional<GcodeDialect> gcodeDialect(std::string_view name) {
  const auto found = std::ranges::find(kNames, name, &decltype(kNames)::value_type::first);
  return found == kNames.end() ? std::nullopt : std::optional(found->second);
}

GcodeHabits habitsOf(std::string_view program, std::optional<GcodeDialect> dialect) {
  GcodeHabits habits;
  if (dialect) {
    habits.dialect = *dialect;
    const bool fanuc = *dialect == GcodeDialect::Fanuc || *dialect == GcodeDialect::Haas;
    habits.wholeThousandths = habits.retractsToLevel = habits.millisecondDwells = fanuc;
    return habits;
  }
  Looks looks;
  bool isFirst = true;
  while (!program.empty()) {
    const auto end = std::min(program.find_first_of("\r\n"), program.size());
    const auto text = gcodeText(program.substr(0, end));
    program.remove_prefix(std::min(end + 1, program.size()));
    if (!text || text->empty()) continue;
    if (text->starts_with('%')) {
      looks.percent = true;
      continue;
    }
    look(*text, isFirst, looks);
    isFirst = false;
  }
  if (!looks.percent || !looks.named || looks.oWords) return habits;
  constexpr double kThousandths = 1000;
  habits.dialect = GcodeDialect::Fanuc;
  habits.guessed = habits.retractsToLevel = habits.millisecondDwells = true;
  habits.wholeThousandths = !looks.points && looks.largest >= kThousandths;
  return habits;
}

}  // namespace t4d::formats
