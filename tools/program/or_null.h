#pragma once

#include <optional>

#include <nlohmann/json.hpp>

namespace t4d::tools {

template <class T>
nlohmann::ordered_json orNull(const std::optional<T>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json();
}

}  // namespace t4d::tools
