#include "t4d/model/units.h"

#include <algorithm>
#include <array>
#include <utility>

namespace t4d::model {

std::optional<double> metresPer(std::string_view lengthUnit) {
  static constexpr std::array<std::pair<std::string_view, double>, 16> kUnits = {
      {{"nm", 1e-9},
       {"um", 1e-6},
       {"µm", 1e-6},
       {"mm", 1e-3},
       {"cm", 1e-2},
       {"dm", 1e-1},
       {"m", 1},
       {"km", 1e3},
       {"in", 0.0254},
       {"inch", 0.0254},
       {"ft", 0.3048},
       {"foot", 0.3048},
       {"yd", 0.9144},
       {"metre", 1},
       {"meter", 1},
       {"millimetre", 1e-3}}};
  const auto* const found = std::find_if(
      kUnits.begin(), kUnits.end(), [&](const auto& unit) { return unit.first == lengthUnit; });
  if (found == kUnits.end()) return std::nullopt;
  return found->second;
}

}  // namespace t4d::model
