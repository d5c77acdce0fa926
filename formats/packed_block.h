#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "t4d/error.h"

/// Blocks of bytes, each compressed in one piece, as VTK's XML files have them.
namespace t4d::formats {

enum class Compressor : std::uint8_t {
  None,
  Zlib,  ///< RFC 1950
  Lz4,   ///< one block of LZ4, without a frame: it has no checksum
  Lzma,  ///< a .xz stream
};

/// "zlib", "LZ4" or "LZMA", for users.
std::string_view nameOf(Compressor compressor);

/// The maximum compression ratio: no block unpacks to more than this many times its size.
std::size_t mostRatio(Compressor compressor);

/// Unpacks exactly `into.size()` bytes; fails if there are more or fewer, or if the data or their
/// checksum are wrong. Takes at most 80 MB of memory besides. The error has no `where`.
Result<void> unpackBlock(Compressor compressor, std::string_view packed, std::span<char> into);

}  // namespace t4d::formats
