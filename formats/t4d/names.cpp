#include "formats/t4d/names.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <optional>

#include <fmt/format.h>

#include "formats/t4d/layout.h"

namespace t4d::formats {
namespace {

/// Takes the first character from `text`; nothing if it is not UTF-8.
std::optional<std::uint32_t> takeCharacter(std::string_view& text) {
  const auto lead = static_cast<unsigned char>(text[0]);
  const int more = lead < 0x80 ? 0 : lead < 0xC2 ? -1 : lead < 0xE0 ? 1 : lead < 0xF0 ? 2 : 3;
  if (more < 0 || lead > 0xF4 || text.size() - 1 < static_cast<std::size_t>(more)) return {};
  std::uint32_t point = more == 0 ? lead : lead & (0x3FU >> more);
  for (int k = 1; k <= more; ++k) {
    const auto next = static_cast<unsigned char>(text[k]);
    if (next >> 6 != 2) return {};
    point = point << 6 | (next & 0x3FU);
  }
  constexpr std::uint32_t kLeast[] = {0, 0x80, 0x800, 0x10000};
  if (point < kLeast[more] || point > 0x10FFFF || point >> 11 == 0x1B) return {};
  text.remove_prefix(1 + static_cast<std::size_t>(more));
  return point;
}

struct Range {
  std::uint32_t first;
  std::uint32_t last;
};
constexpr Range kForbidden[] = {{0x00, 0x1F},     {'/', '/'},       {0x7F, 0x9F},
                                {0x061C, 0x061C}, {0x200E, 0x200F}, {0x202A, 0x202E},
                                {0x2066, 0x2069}};

bool isAllowed(std::uint32_t point) {
  return std::none_of(std::begin(kForbidden), std::end(kForbidden), [&](const Range& range) {
    return point >= range.first && point <= range.last;
  });
}

}  // namespace

Result<void> checkName(std::string_view text) {
  const std::size_t bytes = text.size();
  while (!text.empty()) {
    const auto point = takeCharacter(text);
    if (!point) return invalid("is not UTF-8");
    if (!isAllowed(*point)) {
      return invalid(fmt::format("has the character U+{:04X}, which is not allowed", *point));
    }
  }
  if (bytes == 0 || bytes > t4d_layout::kMaxNameBytes) {
    return invalid(
        fmt::format("has {} bytes; 1 to {} are allowed", bytes, t4d_layout::kMaxNameBytes));
  }
  return {};
}

bool isUtf8(std::string_view text) {
  while (!text.empty()) {
    if (!takeCharacter(text)) return false;
  }
  return true;
}

std::string asName(std::string_view text) {
  std::string name;
  while (!text.empty()) {
    const std::string_view before = text;
    const auto point = takeCharacter(text);
    if (!point) text.remove_prefix(1);
    const bool allowed = point && isAllowed(*point);
    const std::string_view kept = allowed ? before.substr(0, before.size() - text.size()) : "_";
    if (name.size() + kept.size() > t4d_layout::kMaxNameBytes) break;
    name += kept;
  }
  return name.empty() ? "_" : name;
}

}  // namespace t4d::formats
