#pragma once

#include <cctype>
#include <string>

namespace t4d::fuzz {

/// True for a motion that may have a million segments, which is allowed but slow.
inline bool asksForManySegments(const std::string& text) {
  constexpr int kMostDigits = 4;
  int digits = 0;
  for (const char c : text) {
    digits = std::isdigit(static_cast<unsigned char>(c)) != 0 ? digits + 1 : 0;
    if (digits > kMostDigits) return text.find("repeat") != std::string::npos;
  }
  return false;
}

}  // namespace t4d::fuzz
