#include "formats/packed_block.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>
#include <lz4.h>
#include <lzma.h>

#include "formats/zlib_block.h"

namespace t4d::formats {
namespace {

// Each byte of a match's length is at most 255 of its bytes.
constexpr std::size_t kMostLz4Ratio = 255;
// A match of 273 bytes takes 14 binary decisions, of which none takes less than 0.022 bits.
constexpr std::size_t kMostLzmaRatio = 8192;
// What `xz -9` needs, the most that VTK asks for, and a little more.
constexpr std::uint64_t kMostLzmaMemory = std::uint64_t{80} << 20;

bool unpackLz4(std::string_view packed, std::span<char> into) {
  constexpr std::size_t kMost = std::numeric_limits<int>::max();
  if (packed.size() > kMost || into.size() > kMost) return false;
  const auto size = static_cast<int>(into.size());
  return LZ4_decompress_safe(packed.data(), into.data(), static_cast<int>(packed.size()), size) ==
         size;
}

bool unpackLzma(std::string_view packed, std::span<char> into) {
  std::uint64_t memory = kMostLzmaMemory;
  std::size_t at = 0;
  std::size_t end = 0;
  const lzma_ret done = lzma_stream_buffer_decode(
      &memory, 0, nullptr, reinterpret_cast<const std::uint8_t*>(packed.data()), &at, packed.size(),
      reinterpret_cast<std::uint8_t*>(into.data()), &end, into.size());
  return done == LZMA_OK && at == packed.size() && end == into.size();
}

}  // namespace

std::string_view nameOf(Compressor compressor) {
  switch (compressor) {
    case Compressor::None:
      return "nothing";
    case Compressor::Zlib:
      return "zlib";
    case Compressor::Lz4:
      return "LZ4";
    case Compressor::Lzma:
      return "LZMA";
  }
  return {};
}

std::size_t mostRatio(Compressor compressor) {
  switch (compressor) {
    case Compressor::None:
      return 1;
    case Compressor::Zlib:
      return kMostZlibRatio;
    case Compressor::Lz4:
      return kMostLz4Ratio;
    case Compressor::Lzma:
      return kMostLzmaRatio;
  }
  return 1;
}

Result<void> unpackBlock(Compressor compressor, std::string_view packed, std::span<char> into) {
  bool good = false;
  switch (compressor) {
    case Compressor::None:
      good = packed.size() == into.size();
      if (good) std::ranges::copy(packed, into.begin());
      break;
    case Compressor::Zlib:
      return zlibUnpack(packed, into);
    case Compressor::Lz4:
      good = unpackLz4(packed, into);
      break;
    case Compressor::Lzma:
      good = unpackLzma(packed, into);
      break;
  }
  if (good) return {};
  return invalid(
      fmt::format("a compressed block is damaged, or does not unpack to {} bytes", into.size()));
}

}  // namespace t4d::formats
