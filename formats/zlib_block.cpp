#include "formats/zlib_block.h"

#include <limits>
#include <memory>
#include <new>

#include <fmt/format.h>
#include <isa-l/igzip_lib.h>
#include <libdeflate.h>

namespace t4d::formats {
namespace {

/// ISA-L takes input as bytes that are not const, but only reads it.
std::uint8_t* isalBytes(const char* data) {
  return reinterpret_cast<std::uint8_t*>(const_cast<char*>(data));  // NOLINT
}

}  // namespace

// Not ISA-L, which is faster: what it makes of the same bytes differs from run to run, rarely.
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
  constexpr std::size_t kMost = std::numeric_limits<std::uint32_t>::max() / 2;
  if (packed.size() > kMost || into.size() > kMost) {
    return fail(ErrorCode::Unsupported, "a compressed block has more than 2 GiB");
  }
  const auto state = std::make_unique<inflate_state>();
  isal_inflate_init(state.get());
  state->crc_flag = ISAL_ZLIB;
  state->next_in = isalBytes(packed.data());
  state->avail_in = static_cast<std::uint32_t>(packed.size());
  state->next_out = isalBytes(into.data());
  state->avail_out = static_cast<std::uint32_t>(into.size());
  const int done = isal_inflate(state.get());
  if (done != ISAL_DECOMP_OK || state->block_state != ISAL_BLOCK_FINISH || state->avail_out != 0) {
    return invalid(
        fmt::format("a compressed block is damaged, or does not unpack to {} bytes", into.size()));
  }
  return {};
}

}  // namespace t4d::formats
