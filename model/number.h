#pragma once

#include <array>
#include <charconv>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

#if defined(_LIBCPP_VERSION) && _LIBCPP_VERSION < 200000
#define T4D_STRTOD
#endif
#ifdef T4D_STRTOD
#include <cerrno>
#include <cstdlib>

#include <locale.h>
#endif

/// Numbers as text: the only place that calls std::from_chars and std::to_chars.
namespace t4d::model {

#ifdef T4D_STRTOD
/// Does for doubles what std::from_chars does, which libc++ does not have before version 20.
template <class Number>
std::from_chars_result fromCharsByStrtod(std::string_view text, Number& number,
                                         std::chars_format format = std::chars_format::general) {
  const bool fixed = format == std::chars_format::fixed;
  const std::string_view allowed = fixed ? "0123456789.-" : "0123456789.-+eEinfatyINFATY";
  const bool begins = !text.empty() && text[0] != '+';
  const std::string word(text.substr(0, begins ? text.find_first_not_of(allowed) : 0));
  static const locale_t plain = newlocale(LC_ALL_MASK, "C", nullptr);
  char* stop = nullptr;
  errno = 0;
  Number read = 0;
  if constexpr (std::is_same_v<Number, float>) {
    read = strtof_l(word.c_str(), &stop, plain);
  } else if constexpr (std::is_same_v<Number, double>) {
    read = strtod_l(word.c_str(), &stop, plain);
  } else {
    read = strtold_l(word.c_str(), &stop, plain);
  }
  const auto used = static_cast<std::size_t>(stop - word.c_str());
  if (used == 0) return {text.data(), std::errc::invalid_argument};
  // strtod also says so of numbers below the least normal one, which it has read.
  const bool inRange = errno != ERANGE || (read != 0 && read - read == 0);
  if (inRange) number = read;
  return {text.data() + used, inRange ? std::errc() : std::errc::result_out_of_range};
}
#endif

/// std::from_chars of what the text begins with; `form` is the base of a whole number or a
/// std::chars_format.
template <class Number, class... Form>
std::from_chars_result fromChars(std::string_view text, Number& number, Form... form) {
#ifdef T4D_STRTOD
  if constexpr (std::is_floating_point_v<Number>) return fromCharsByStrtod(text, number, form...);
#endif
  return std::from_chars(text.data(), text.data() + text.size(), number, form...);
}

/// Takes a number from the beginning of a text. Nothing if there is none, or one beyond the range
/// of its type: the text stays as it is.
template <class Number, class... Form>
std::optional<Number> takeNumber(std::string_view& text, Form... form) {
  Number number{};
  const auto [stop, problem] = fromChars(text, number, form...);
  if (problem != std::errc()) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(stop - text.data()));
  return number;
}

/// The number that a text is; nothing if it is none, or has more than it.
template <class Number, class... Form>
std::optional<Number> numberIn(std::string_view text, Form... form) {
  const auto number = takeNumber<Number>(text, form...);
  return text.empty() ? number : std::nullopt;
}

/// std::from_chars takes no plus sign; people write them.
inline std::string_view withoutPlus(std::string_view text) {
  const bool has = text.size() > 1 && text[0] == '+' && text[1] != '-' && text[1] != '+';
  return text.substr(has ? 1 : 0);
}

/// Appends the shortest text that is read back as the same number.
template <class Number, class... Format>
void appendNumber(std::string& text, Number number, Format... format) {
  std::array<char, 32> digits{};
  const auto end =
      std::to_chars(digits.data(), digits.data() + digits.size(), number, format...).ptr;
  text.append(digits.data(), end);
}

}  // namespace t4d::model
