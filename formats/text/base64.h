#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace t4d::formats {

/// The bytes in Base64 (RFC 4648, section 4), padded with `=`.
std::string base64(std::span<const std::uint8_t> bytes);

/// The bytes that such a text stands for; blanks and line breaks are skipped. Several texts, each
/// padded, may follow each other. Stops after `most` bytes, or a few more. Nothing if a character
/// is not a Base64 digit, or if the last group is incomplete.
std::optional<std::string> fromBase64(std::string_view text, std::size_t most = std::string::npos);

}  // namespace t4d::formats
