#include "t4d/voxel4d/volumes/unit_names.h"

#include <algorithm>
#include <array>
#include <initializer_list>

#include "t4d/voxel4d/volumes/header_text.h"

namespace t4d::voxel4d {
namespace {

struct UnitNames {
  std::string_view unit;
  std::initializer_list<std::string_view> names;  ///< in lower case, without the s of a plural
};

const std::array<UnitNames, 15> kUnits = {{
    {"angstrom", {"\u00C5", "\u212B"}},
    {"nm", {"nanometer", "nanometre"}},
    // "\u00B5" is a micro sign, "\u03BC" the Greek letter, and ImageJ writes the first one out.
    {"um", {"micrometer", "micrometre", "micron", "\u00B5m", "\u03BCm", "\\u00b5m"}},
    {"mm", {"millimeter", "millimetre"}},
    {"cm", {"centimeter", "centimetre"}},
    {"m", {"meter", "metre"}},
    {"km", {"kilometer", "kilometre"}},
    {"ns", {"nanosecond"}},
    {"us", {"microsecond", "\u00B5s", "\u03BCs"}},
    {"ms", {"millisecond", "msec"}},
    {"s", {"second", "sec"}},
    {"min", {"minute"}},
    {"h", {"hour"}},
    {"d", {"day"}},
    {"inch", {"inches"}},
}};

}  // namespace

std::string unitNamed(std::string_view name) {
  // Prefixes of short names differ by case: mm and Mm.
  constexpr std::size_t kShort = 3;
  std::string word(name);
  if (word.size() > kShort) word = lowerCase(std::move(word));
  const std::string singular =
      word.size() > kShort && word.ends_with('s') ? word.substr(0, word.size() - 1) : word;
  for (const auto& [unit, names] : kUnits) {
    const auto is = [&](std::string_view known) { return word == known || singular == known; };
    if (is(unit) || std::ranges::any_of(names, is)) return std::string(unit);
  }
  return std::string(name);
}

}  // namespace t4d::voxel4d
