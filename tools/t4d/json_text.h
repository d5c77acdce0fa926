#pragma once

#include <optional>
#include <string>

#include <nlohmann/json.hpp>

namespace t4d::tools {

/// A report as text, indented. Bytes that are not UTF-8 are replaced and control characters
/// escaped: names in a file must not command a terminal.
std::string jsonText(const nlohmann::ordered_json& value);

template <class T>
nlohmann::ordered_json orNull(const std::optional<T>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json();
}

}  // namespace t4d::tools
