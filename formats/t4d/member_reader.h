#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "t4d/error.h"
#include "t4d/mesh.h"

namespace t4d::formats {

/// The maximum count: every JSON parser reads it exactly, and a sum of all counts in a manifest
/// does not overflow.
inline constexpr std::uint64_t kMostCount = std::uint64_t{1} << 42;

/// The members of an object, read one after another; the first that is wrong is kept.
class MemberReader {
 public:
  MemberReader(const nlohmann::ordered_json& object, std::string of)
      : object_(object), of_(std::move(of)) {
    if (!object.is_object()) wrong_ = fmt::format("{} is not an object", of_);
  }

  std::string text(const char* name) {
    const nlohmann::ordered_json* found = member(name);
    if (found == nullptr || !found->is_string()) return miss(name, "a string"), std::string();
    return found->get<std::string>();
  }
  std::uint64_t count(const char* name) {
    const nlohmann::ordered_json* found = member(name);
    const bool whole = found != nullptr && found->is_number_unsigned();
    if (!whole || found->get<std::uint64_t>() > kMostCount) {
      return miss(name, fmt::format("a whole number from 0 to {}", kMostCount)), 0;
    }
    return found->get<std::uint64_t>();
  }
  double number(const char* name) {
    const nlohmann::ordered_json* found = member(name);
    const double value = found != nullptr && found->is_number()
                             ? found->get<double>()
                             : std::numeric_limits<double>::quiet_NaN();
    if (!std::isfinite(value)) miss(name, "a finite number");
    return value;
  }
  std::string hex(const char* name, std::size_t digits) {
    const std::string value = text(name);
    constexpr const char* kDigits = "0123456789abcdef";
    if (value.size() != digits || value.find_first_not_of(kDigits) != std::string::npos) {
      miss(name, fmt::format("{} hexadecimal digits in lower case", digits));
    }
    return value;
  }
  /// Three numbers; nothing for null.
  std::optional<model::Point3> point(const char* name) {
    const nlohmann::ordered_json* found = member(name);
    if (found != nullptr && found->is_null()) return std::nullopt;
    model::Point3 point = model::Point3::Zero();
    bool sound = found != nullptr && found->is_array() && found->size() == 3;
    for (std::size_t i = 0; sound && i < 3; ++i) {
      sound = (*found)[i].is_number() && std::isfinite((*found)[i].get<double>());
      if (sound) point[static_cast<Eigen::Index>(i)] = (*found)[i].get<double>();
    }
    if (!sound) miss(name, "three numbers, or null");
    return point;
  }
  const nlohmann::ordered_json& array(const char* name) {
    static const nlohmann::ordered_json kNone = nlohmann::ordered_json::array();
    const nlohmann::ordered_json* found = member(name);
    if (found == nullptr || !found->is_array()) return miss(name, "an array"), kNone;
    return *found;
  }
  const nlohmann::ordered_json& object(const char* name) {
    static const nlohmann::ordered_json kNone = nlohmann::ordered_json::object();
    const nlohmann::ordered_json* found = member(name);
    if (found == nullptr || !found->is_object()) return miss(name, "an object"), kNone;
    return *found;
  }

  void miss(const char* name, const std::string& expected) {
    if (!wrong_) wrong_ = fmt::format("'{}' of {} must be {}", name, of_, expected);
  }
  Result<void> result() const { return wrong_ ? Result<void>(invalid(*wrong_)) : Result<void>(); }

 private:
  const nlohmann::ordered_json* member(const char* name) const {
    if (!object_.is_object()) return nullptr;
    const auto found = object_.find(name);
    return found == object_.end() ? nullptr : &*found;
  }

  const nlohmann::ordered_json& object_;
  std::string of_;
  std::optional<std::string> wrong_;
};

}  // namespace t4d::formats
