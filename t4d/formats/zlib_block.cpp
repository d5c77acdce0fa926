#include "t4d/formats/zlib_block.h"

#include <limits>
#include <memory>
#include <vector>

#include <fmt/format.h>
#include <isa-l/igzip_lib.h>

namespace t4d::formats {
namespace {

/// ISA-L takes input as bytes that are not const, but only reads it.
std::uint8_t* isalBytes(const char* data) {
  return reinterpret_cast<std::uint8_t*>(const_cast<char*>(data));  // NOLINT
}

}  // namespace

std::string zlibCompressed(std::string_view bytes) {
  std::vector<std::uint8_t> work(ISAL_DEF_LVL1_DEFAULT);
  // What cannot be compressed is stored, with 5 bytes for each 64 KiB.
  std::string packed(bytes.size() + bytes.size() / 1024 + 64, '\0');
  const auto stream = std::make_unique<isal_zstream>();
  isal_deflate_stateless_init(stream.get());
  stream->level = 1;
  stream->level_buf = work.data();
  stream->level_buf_size = static_cast<std::uint32_t>(work.size());
  stream->gzip_flag = IGZIP_ZLIB;
  stream->end_of_stream = 1;
  stream->next_in = isalBytes(bytes.data());
  stream->avail_in = static_cast<std::uint32_t>(bytes.size());
  stream->next_out = isalBytes(packed.data());
  stream->avail_out = static_cast<std::uint32_t>(packed.size());
  isal_deflate_stateless(stream.get());
  packed.resize(stream->total_out);
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
