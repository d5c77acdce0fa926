#include "model/units.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>

namespace t4d::model {
namespace {

/// A unit as a whole number of the smallest one. All are below 2^53, so exact as doubles.
struct Unit {
  std::string_view name;
  std::uint64_t size;
};

constexpr std::uint64_t kNanometresPerMetre = 1'000'000'000;
constexpr Unit kLengths[] = {{"nm", 1},
                             {"um", 1'000},
                             {"µm", 1'000},
                             {"mm", 1'000'000},
                             {"millimetre", 1'000'000},
                             {"cm", 10'000'000},
                             {"dm", 100'000'000},
                             {"m", kNanometresPerMetre},
                             {"metre", kNanometresPerMetre},
                             {"meter", kNanometresPerMetre},
                             {"km", 1'000'000'000'000},
                             {"in", 25'400'000},
                             {"inch", 25'400'000},
                             {"ft", 304'800'000},
                             {"foot", 304'800'000},
                             {"yd", 914'400'000}};

constexpr std::uint64_t kNanosecondsPerSecond = 1'000'000'000;
constexpr Unit kTimes[] = {{"ns", 1},
                           {"us", 1'000},
                           {"µs", 1'000},
                           {"ms", 1'000'000},
                           {"millisecond", 1'000'000},
                           {"s", kNanosecondsPerSecond},
                           {"sec", kNanosecondsPerSecond},
                           {"second", kNanosecondsPerSecond},
                           {"min", 60 * kNanosecondsPerSecond},
                           {"minute", 60 * kNanosecondsPerSecond},
                           {"h", 3'600 * kNanosecondsPerSecond},
                           {"hour", 3'600 * kNanosecondsPerSecond},
                           {"d", 86'400 * kNanosecondsPerSecond},
                           {"day", 86'400 * kNanosecondsPerSecond}};

std::optional<std::uint64_t> sizeOf(std::span<const Unit> units, std::string_view name) {
  const auto found =
      std::find_if(units.begin(), units.end(), [&](const Unit& unit) { return unit.name == name; });
  if (found == units.end()) return std::nullopt;
  return found->size;
}

std::optional<UnitConversion> conversion(std::span<const Unit> units, std::string_view from,
                                         std::string_view to) {
  if (from == to) return UnitConversion{};
  const auto sizeOfFrom = sizeOf(units, from);
  const auto sizeOfTo = sizeOf(units, to);
  if (!sizeOfFrom || !sizeOfTo) return std::nullopt;
  const std::uint64_t common = std::gcd(*sizeOfFrom, *sizeOfTo);
  return UnitConversion{static_cast<double>(*sizeOfFrom / common),
                        static_cast<double>(*sizeOfTo / common)};
}

}  // namespace

std::optional<double> metresPer(std::string_view lengthUnit) {
  const auto size = sizeOf(kLengths, lengthUnit);
  if (!size) return std::nullopt;
  return static_cast<double>(*size) / static_cast<double>(kNanometresPerMetre);
}

std::optional<UnitConversion> lengthConversion(std::string_view from, std::string_view to) {
  return conversion(kLengths, from, to);
}

std::optional<UnitConversion> timeConversion(std::string_view from, std::string_view to) {
  return conversion(kTimes, from, to);
}

}  // namespace t4d::model
