#include "tools/t4d/json_text.h"

#include <fmt/format.h>

namespace t4d::tools {

std::string jsonText(const nlohmann::ordered_json& value) {
  // JSON allows these control characters as they are.
  std::string text;
  for (const char c : value.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace)) {
    const bool second = text.ends_with('\xC2') && static_cast<unsigned char>(c) < 0xA0;
    if (second) text.pop_back();
    if (second || c == '\x7F') {
      text += fmt::format("\\u{:04x}", static_cast<unsigned char>(c));
    } else {
      text += c;
    }
  }
  return text;
}

}  // namespace t4d::tools
