#pragma once

#include <optional>
#include <string_view>

namespace t4d::model {

/// Metres per unit of length ("mm", "m", "in", ...); nothing for an unknown unit.
std::optional<double> metresPer(std::string_view lengthUnit);

/// Converts numbers from one unit to another with a fraction in lowest terms. If one unit is a
/// multiple of the other, like m of mm, the result is rounded once.
struct UnitConversion {
  double numerator = 1;
  double denominator = 1;

  double operator()(double value) const { return value * numerator / denominator; }
  bool isIdentity() const { return numerator == denominator; }
};

/// Converts lengths given in `from` to `to`; nothing if the units differ and one is unknown.
std::optional<UnitConversion> lengthConversion(std::string_view from, std::string_view to);

/// Converts times given in `from` ("s", "ms", "min", ...) to `to`; nothing if the units differ and
/// one is unknown.
std::optional<UnitConversion> timeConversion(std::string_view from, std::string_view to);

}  // namespace t4d::model
