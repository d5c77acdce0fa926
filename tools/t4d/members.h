#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <optional>
#include <ranges>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "tools/t4d/json_text.h"

/// Reports that describe themselves. One function names the members of a report, each with its
/// value and what it means:
///
///     void describe(Members& members, const DuReport& report) {
///       members("bytes", report.bytes, "Size of the file, in bytes.").joined(Joined::Added);
///       members("chunks", report.chunks, "By type.", [](Members& own, const T4dChunks& some) {
///         own("type", some.type, "The type, such as SLAB.");
///       });
///     }
///
/// From it follow the JSON of a report (`reportText`); the JSON Schema that `t4d VERB --help
/// --json` has (`schemaOf`), for which the report is one made by default; and how the reports on
/// parts are joined (`rulesOf`).
namespace t4d::tools {

/// How a member of a report follows from those of the reports on parts.
enum class Joined {
  Added,     ///< numbers, or the numbers of two lists; null if one of them is
  Most,      ///< the largest; null counts as nothing
  First,     ///< of the first part
  Last,      ///< of the last part
  All,       ///< whether it is true of all
  Appended,  ///< lists, one after the other
  Unknown    ///< null: only the joined file can tell
};
using JoinRules = std::map<std::string, Joined, std::less<>>;

class Members;

/// What is said of a member besides its meaning and what follows from its type.
class Member {
 public:
  Member(Members& all, std::string name) : all_(all), name_(std::move(name)) {}

  Member& atLeast(const nlohmann::ordered_json& least) { return limit("minimum", least); }
  Member& atMost(const nlohmann::ordered_json& most) { return limit("maximum", most); }
  Member& above(const nlohmann::ordered_json& bound) { return limit("exclusiveMinimum", bound); }
  /// A list has at least so many items.
  Member& itemsFrom(std::size_t least) { return limit("minItems", least); }
  /// A text is not empty.
  Member& notEmpty() { return limit("minLength", 1); }
  Member& pattern(const char* expression) { return limit("pattern", expression); }
  Member& oneOf(const std::vector<std::string>& words);
  /// The value can also be null, as that of a number that is not finite is.
  Member& orNull();
  /// The value is null on this condition.
  Member& nullIf(bool unknown);
  /// The member is there on this condition.
  Member& onlyIf(bool present);
  Member& joined(Joined rule);
  /// The value has one of these JSON types.
  Member& types(const std::vector<std::string>& names) { return limit("type", names); }
  /// The numbers of a list can also be null, as those that are not finite are.
  Member& itemsOrNull();

 private:
  Member& limit(const char* keyword, const nlohmann::ordered_json& value);

  Members& all_;
  std::string name_;
};

/// The value of a member that is no object.
struct NoMembers {};

class Members {
 public:
  enum class Of { Values, Schema };
  explicit Members(Of what) : what_(what) {}

  /// Adds a member: a number, a truth value, a text, a JSON value, or a list, an array or a map of
  /// these. The members of an object are named by `own(Members&, value)`, or by `describe`. An
  /// empty optional is null.
  template <class T, class Own = NoMembers>
  Member operator()(const char* name, const T& value, const char* meaning, const Own& own = {}) {
    if (what_ == Of::Values) {
      json_[name] = valueOf(value, own);
    } else {
      addSchema(name, schemaOf<T>(own), meaning);
    }
    return {*this, name};
  }

  /// Adds a member that is there if it has a value.
  template <class T, class Own = NoMembers>
  Member ifKnown(const char* name, const std::optional<T>& value, const char* meaning,
                 const Own& own = {}) {
    if (what_ == Of::Schema) return (*this)(name, T{}, meaning, own).onlyIf(false);
    if (value) json_[name] = valueOf(*value, own);
    return {*this, name};
  }

  /// The JSON of the values, or the JSON Schema of an object that has them.
  const nlohmann::ordered_json& json() const { return json_; }
  const JoinRules& rules() const { return rules_; }

  template <class T, class Own = NoMembers>
  static nlohmann::ordered_json valueOf(const T& value, const Own& own = {});
  template <class T, class Own = NoMembers>
  static nlohmann::ordered_json schemaOf(const Own& own = {});

 private:
  friend class Member;

  void addSchema(const char* name, nlohmann::ordered_json schema, const char* meaning);

  Of what_;
  nlohmann::ordered_json json_ = nlohmann::ordered_json::object();
  JoinRules rules_;
};

template <class T>
constexpr bool kIsOptional = false;
template <class T>
constexpr bool kIsOptional<std::optional<T>> = true;
template <class T>
constexpr std::size_t kArraySize = 0;
template <class T, std::size_t N>
constexpr std::size_t kArraySize<std::array<T, N>> = N;
/// Points and vectors of Eigen.
template <class T>
requires requires { T::SizeAtCompileTime; }
constexpr std::size_t kArraySize<T> = std::size_t{T::SizeAtCompileTime};
template <class T>
concept IsText =
    std::convertible_to<const T&, std::string_view> || std::same_as<T, std::filesystem::path>;
template <class T>
concept IsMap = requires {
  typename T::mapped_type;
};
template <class T, class Own>
concept HasOwnMembers = std::invocable<const Own&, Members&, const T&>;
template <class T>
concept IsDescribed = requires(Members& members, const T& value) {
  describe(members, value);
};

template <class T, class Own>
nlohmann::ordered_json Members::valueOf(const T& value, const Own& own) {
  if constexpr (kIsOptional<T>) {
    return value ? valueOf(*value, own) : nlohmann::ordered_json();
  } else if constexpr (HasOwnMembers<T, Own>) {
    Members members(Of::Values);
    own(members, value);
    return std::move(members.json_);
  } else if constexpr (IsDescribed<T>) {
    Members members(Of::Values);
    describe(members, value);
    return std::move(members.json_);
  } else if constexpr (std::same_as<T, std::filesystem::path>) {
    return value.string();
  } else if constexpr (IsText<T>) {
    return std::string_view(value);
  } else if constexpr (IsMap<T>) {
    auto all = nlohmann::ordered_json::object();
    for (const auto& [name, one] : value) all[name] = valueOf(one, own);
    return all;
  } else if constexpr (std::same_as<T, nlohmann::ordered_json>) {
    return value;
  } else if constexpr (std::ranges::range<const T>) {
    auto all = nlohmann::ordered_json::array();
    for (const auto& one : value) all.push_back(valueOf(one, own));
    return all;
  } else {
    return value;
  }
}

template <class T, class Own>
nlohmann::ordered_json Members::schemaOf(const Own& own) {
  using nlohmann::ordered_json;
  if constexpr (kIsOptional<T>) {
    ordered_json schema = schemaOf<typename T::value_type>(own);
    schema["type"] = {schema["type"], "null"};
    return schema;
  } else if constexpr (HasOwnMembers<T, Own> || IsDescribed<T>) {
    Members members(Of::Schema);
    if constexpr (HasOwnMembers<T, Own>) {
      own(members, T{});
    } else {
      describe(members, T{});
    }
    return std::move(members.json_);
  } else if constexpr (IsText<T>) {
    return {{"type", "string"}};
  } else if constexpr (IsMap<T>) {
    return {{"type", "object"}, {"additionalProperties", schemaOf<typename T::mapped_type>(own)}};
  } else if constexpr (std::same_as<T, ordered_json>) {
    return {{"type", "object"}};
  } else if constexpr (std::ranges::range<const T>) {
    ordered_json schema = {{"type", "array"},
                           {"items", schemaOf<std::ranges::range_value_t<const T>>(own)}};
    if constexpr (kArraySize < T >> 0) {
      schema["minItems"] = kArraySize<T>;
      schema["maxItems"] = kArraySize<T>;
    }
    return schema;
  } else if constexpr (std::same_as<T, bool>) {
    return {{"type", "boolean"}};
  } else if constexpr (std::unsigned_integral<T>) {
    return {{"type", "integer"}, {"minimum", 0}};
  } else if constexpr (std::integral<T>) {
    return {{"type", "integer"}};
  } else {
    static_assert(std::floating_point<T>, "what has members needs a function that names them");
    return {{"type", "number"}};
  }
}

/// A report as the text of its JSON.
template <IsDescribed T>
std::string reportText(const T& report) {
  return jsonText(Members::valueOf(report));
}

/// The rules by which reports on parts are joined.
template <IsDescribed T>
JoinRules rulesOf() {
  Members members(Members::Of::Schema);
  describe(members, T{});
  return members.rules();
}

/// Adds what a run took: `seconds`, and `peak_bytes` of this process.
void addCosts(Members& members, double seconds);

}  // namespace t4d::tools
