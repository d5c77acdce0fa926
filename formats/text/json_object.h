#pragma once

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>

#include <Eigen/Core>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "t4d/error.h"

namespace t4d::formats {

/// Ends parsing; caught at the end of the function that parses.
struct JsonRefusal {
  Error error;
};

[[noreturn]] inline void refuseJson(std::string message, Place where) {
  throw JsonRefusal{Error{ErrorCode::InvalidInput, std::move(message), std::move(where)}};
}

/// The place of a member, `.key`, or of an element, `[2]`.
inline Place jsonPlace(Place of, const std::string& member) {
  of.part += member;
  return of;
}

/// A JSON object with the keys it may have, read one by one.
class JsonObject {
 public:
  JsonObject(const nlohmann::json& value, Place where,
             std::initializer_list<std::string_view> known)
      : value_(value), where_(std::move(where)) {
    if (!value.is_object()) {
      refuseJson(fmt::format("is {}, where an object is expected", describe(value)), where_);
    }
    for (const auto& [key, unused] : value.items()) {
      if (std::find(known.begin(), known.end(), key) == known.end()) {
        refuseJson(
            fmt::format("has the unknown key '{}'; known are {}", key, fmt::join(known, ", ")),
            where_);
      }
    }
  }

  bool has(const char* key) const { return value_.contains(key); }
  const Place& where() const { return where_; }
  Place where(const char* key) const { return jsonPlace(where_, std::string(".") + key); }

  const nlohmann::json& need(const char* key) const {
    const auto found = value_.find(key);
    if (found == value_.end()) refuseJson(fmt::format("lacks the key '{}'", key), where_);
    return *found;
  }
  double number(const char* key, double otherwise) const {
    return has(key) ? numberOf(need(key), where(key)) : otherwise;
  }
  std::string text(const char* key) const {
    if (!has(key)) return {};
    const nlohmann::json& value = need(key);
    if (!value.is_string()) {
      refuseJson(fmt::format("is {}, where text is expected", describe(value)), where(key));
    }
    return value.get<std::string>();
  }
  std::uint64_t count(const char* key, std::uint64_t otherwise) const {
    if (!has(key)) return otherwise;
    const nlohmann::json& value = need(key);
    if (!value.is_number_unsigned()) {
      refuseJson(fmt::format("is {}, where a whole number from 1 on is expected", describe(value)),
                 where(key));
    }
    return value.get<std::uint64_t>();
  }
  template <int Size>
  Eigen::Matrix<double, Size, 1> numbers(const char* key,
                                         const Eigen::Matrix<double, Size, 1>& otherwise) const {
    if (!has(key)) return otherwise;
    const nlohmann::json& value = need(key);
    if (!value.is_array() || value.size() != Size) {
      refuseJson(
          fmt::format("is {}, where an array of {} numbers is expected", describe(value), Size),
          where(key));
    }
    Eigen::Matrix<double, Size, 1> result;
    for (int i = 0; i < Size; ++i) {
      result[i] = numberOf(value[static_cast<std::size_t>(i)],
                           jsonPlace(where(key), fmt::format("[{}]", i)));
    }
    return result;
  }
  const nlohmann::json& array(const char* key) const {
    const nlohmann::json& value = need(key);
    if (!value.is_array()) {
      refuseJson(fmt::format("is {}, where an array is expected", describe(value)), where(key));
    }
    return value;
  }

 private:
  /// Scalars as written; only the kind of arrays and objects, which may be deep.
  static std::string describe(const nlohmann::json& value) {
    if (value.is_array()) return fmt::format("an array of {} values", value.size());
    if (value.is_object()) return "an object";
    constexpr std::size_t kShown = 40;
    const std::string text = value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    return text.size() > kShown ? text.substr(0, kShown) + "..." : text;
  }
  static double numberOf(const nlohmann::json& value, const Place& where) {
    if (!value.is_number()) {
      refuseJson(fmt::format("is {}, where a number is expected", describe(value)), where);
    }
    return value.get<double>();
  }

  const nlohmann::json& value_;
  Place where_;
};

/// The message of the JSON parser without its own marks: "[json.exception.parse_error.101] parse
/// error at line 3, column 5: ...".
inline std::string jsonMessage(const nlohmann::json::exception& error) {
  const std::string_view what = error.what();
  const auto begin = what.find("] ");
  return std::string(begin == what.npos ? what : what.substr(begin + 2));
}

}  // namespace t4d::formats
