#pragma once

#include <algorithm>
#include <cctype>
#include <cstring>
#include <string>

namespace t4d::tools {

/// A text as one word of a shell command.
inline std::string shellWord(const std::string& text) {
  const auto plain = [](unsigned char c) {
    return std::isalnum(c) != 0 || c >= 0x80 || (c != 0 && std::strchr("/._-+,:@%=", c) != nullptr);
  };
  if (!text.empty() && std::ranges::all_of(text, plain)) return text;
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

}  // namespace t4d::tools
