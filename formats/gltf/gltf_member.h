#pragma once

#include <cstdint>
#include <optional>

#include <nlohmann/json.hpp>

namespace t4d::formats {

/// A whole number that is a member of an object of a glTF document: `otherwise` if it is missing,
/// nothing if it is something else.
inline std::optional<std::uint64_t> wholeMember(const nlohmann::json& object, const char* member,
                                                std::optional<std::uint64_t> otherwise = {}) {
  const auto found = object.find(member);
  if (found == object.end()) return otherwise;
  if (!found->is_number_unsigned()) return std::nullopt;
  return found->get<std::uint64_t>();
}

/// An element of an array that is a member of a document; null if there is none, or it is no
/// object.
template <class Json>
Json* objectAt(Json& document, const char* array, std::optional<std::uint64_t> index) {
  const auto all = document.find(array);
  if (!index || all == document.end() || !all->is_array() || *index >= all->size()) return nullptr;
  Json& element = (*all)[*index];
  return element.is_object() ? &element : nullptr;
}

}  // namespace t4d::formats
