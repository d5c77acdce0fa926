#include "conformance/driver/plain_text.h"

#include <cstdint>

#include <fmt/format.h>

namespace t4d::conformance {
namespace {

/// The number of bytes of the first character of `text`; 0 if it has to be escaped.
std::size_t characterBytes(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  if (byte(0) < 0x80) return byte(0) >= 0x20 && byte(0) != 0x7F ? 1 : 0;
  const std::size_t size = byte(0) >= 0xF0 ? 4 : byte(0) >= 0xE0 ? 3 : 2;
  if (byte(0) < 0xC0 || byte(0) >= 0xF8 || text.size() < size) return 0;
  std::uint32_t code = byte(0) & (0x7FU >> size);
  for (std::size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return 0;
    code = (code << 6) | (byte(i) & 0x3F);
  }
  constexpr std::uint32_t kLeast[] = {0, 0, 0xA0, 0x800, 0x10000};  // U+0080 to U+009F: control
  const bool surrogate = code >= 0xD800 && code < 0xE000;
  const bool noncharacter = (code & 0xFFFE) == 0xFFFE;
  return code < kLeast[size] || code > 0x10FFFF || surrogate || noncharacter ? 0 : size;
}

}  // namespace

std::string plain(std::string_view text, std::size_t most) {
  std::string shown;
  for (std::size_t at = 0; at < text.size();) {
    if (at >= most) return shown + "...";
    const std::size_t size = characterBytes(text.substr(at));
    if (size > 0) {
      shown += text.substr(at, size);
    } else if (text[at] == '\n') {
      shown += "\\n";
    } else {
      shown += fmt::format("\\x{:02x}", static_cast<unsigned char>(text[at]));
    }
    at += size > 0 ? size : 1;
  }
  return shown;
}

}  // namespace t4d::conformance
