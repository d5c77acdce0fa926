#include "formats/zlib_block.h"

#include <memory>
#include <new>

#include <fmt/format.h>
#include <libdeflate.h>

namespace t4d::formats {

// Not ISA-L, which is faster: what it makes of the same bytes differs from run to run, rarely.
// It unpacks in 6/7 of the time.
std::string zlibCompressed(std::string_view bytes) {
  const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
      libdeflate_alloc_compressor(1), &libdeflate_free_compressor);
  if (!compressor) throw std::bad_alloc();
  std::string packed(libdeflate_zlib_compress_bound(compressor.get(), bytes.size()), '\0');
  packed.resize(libdeflate_zlib_compress(compressor.get(), bytes.data(), bytes.size(),
                                         packed.data(), packed.size()));
  return packed;
}

Result<void> zlibUnpack(std::string_view packed, std::span<char> into) {
  const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)>
      decompressor(libdeflate_alloc_decompressor(), &libdeflate_free_decompressor);
  if (!decompressor) throw std::bad_alloc();
  std::size_t used = 0;
  std::size_t made = 0;
  const libdeflate_result done = libdeflate_zlib_decompress_ex(
      decompressor.get(), packed.data(), packed.size(), into.data(), into.size(), &used, &made);
  if (done != LIBDEFLATE_SUCCESS || made != into.size()) {
    return invalid(
        fmt::format("a compressed block is damaged, or does not unpack to {} bytes", into.size()));
  }
  return {};
}

std::uint32_t zlibCrc32(std::string_view bytes, std::uint32_t before) {
  return libdeflate_crc32(before, bytes.data(), bytes.size());
}

}  // namespace t4d::formats
