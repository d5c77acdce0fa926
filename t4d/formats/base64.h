#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace t4d::formats {

/// The bytes in Base64 (RFC 4648, section 4), padded with `=`.
std::string base64(std::span<const std::uint8_t> bytes);

}  // namespace t4d::formats
