#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "t4d/error.h"

/// Data compressed in one piece, in the zlib format (RFC 1950).
namespace t4d::formats {

/// The maximum compression ratio of deflate: no piece unpacks to more than this many times its
/// size.
inline constexpr std::size_t kMostZlibRatio = 1032;

/// Compresses fast rather than well.
std::string zlibCompressed(std::string_view bytes);

/// Unpacks exactly `into.size()` bytes; fails if there are more or fewer, or if the data or their
/// checksum are wrong. The error has no `where`.
Result<void> zlibUnpack(std::string_view packed, std::span<char> into);

/// The CRC-32 of zlib and ZIP; `before` is that of the bytes before these.
std::uint32_t zlibCrc32(std::string_view bytes, std::uint32_t before = 0);

}  // namespace t4d::formats
