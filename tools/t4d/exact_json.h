#pragma once

#include <cmath>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace t4d::tools {

/// A double in JSON without loss: one that is not finite, which JSON does not have, as text.
inline nlohmann::ordered_json exact(double value) {
  if (std::isfinite(value)) return value;
  return fmt::format("{}", value);
}

/// Throws nlohmann::json::exception for anything else.
inline double exactDouble(const nlohmann::ordered_json& value) {
  if (!value.is_string()) return value.get<double>();
  const std::string text = value.get<std::string>();
  if (text == "inf") return std::numeric_limits<double>::infinity();
  if (text == "-inf") return -std::numeric_limits<double>::infinity();
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace t4d::tools
