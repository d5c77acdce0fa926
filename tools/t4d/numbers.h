#pragma once

#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "model/number.h"
#include "t4d/mesh.h"

namespace t4d::tools {

/// Parses a finite number; nothing if the text is not one.
inline std::optional<double> numberOf(std::string_view word) {
  const auto number = model::numberIn<double>(model::withoutPlus(word));
  return number && std::isfinite(*number) ? number : std::nullopt;
}

/// Parses finite numbers with a separator, like "1,0,0,0,2.5" or "0:5:11".
inline std::optional<std::vector<double>> numbersBetween(std::string_view text, char separator) {
  std::vector<double> numbers;
  while (true) {
    const std::size_t end = text.find(separator);
    const auto number = numberOf(text.substr(0, end));
    if (!number) return std::nullopt;
    numbers.push_back(*number);
    if (end == std::string_view::npos) return numbers;
    text.remove_prefix(end + 1);
  }
}

/// Part K of N of K/N, whole numbers with K from 1 to N.
inline std::optional<model::Part> partOf(std::string_view text) {
  const auto numbers = numbersBetween(text, '/');
  if (!numbers || numbers->size() != 2) return std::nullopt;
  const double number = (*numbers)[0];
  const double count = (*numbers)[1];
  if (!(number >= 1 && number <= count && count <= 1e9)) return std::nullopt;
  if (number != std::floor(number) || count != std::floor(count)) return std::nullopt;
  return model::Part{static_cast<std::uint64_t>(number), static_cast<std::uint64_t>(count)};
}

/// The times of A:B:N, evenly spaced from A to B, with N a whole number from 1 to `most`; or of a
/// list T1,T2,... of up to as many.
inline std::optional<std::vector<double>> timesOf(std::string_view text, std::uint64_t most) {
  if (text.find(':') == std::string_view::npos) {
    auto list = numbersBetween(text, ',');
    return list && list->size() <= most ? list : std::nullopt;
  }
  const auto numbers = numbersBetween(text, ':');
  if (!numbers || numbers->size() != 3) return std::nullopt;
  const double n = (*numbers)[2];
  if (!(n >= 1 && n <= static_cast<double>(most)) || n != std::floor(n)) return std::nullopt;
  return model::evenTimes({(*numbers)[0], (*numbers)[1]}, static_cast<std::uint64_t>(n));
}

}  // namespace t4d::tools
