#pragma once

#include <optional>
#include <string_view>

namespace t4d::model {

/// Metres in one unit of length ("mm", "m", "in", ...); nothing for a name that is not known.
std::optional<double> metresPer(std::string_view lengthUnit);

}  // namespace t4d::model
