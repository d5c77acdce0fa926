#include "t4d/voxel4d/volumes/zarr_codec.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>

#include <blosc.h>
#include <fmt/format.h>
#include <isa-l/igzip_lib.h>
#include <lz4.h>
#include <zstd.h>

#include "t4d/system/crc32c.h"
#include "t4d/system/upper_halves.h"

namespace t4d::voxel4d {
namespace {

struct CodecRow {
  std::string_view name;
  ZarrCodec codec;
  /// The most that a byte can stand for.
  std::uint64_t mostBytes;
};
constexpr std::array kCodecRows = {
    CodecRow{"blosc", ZarrCodec::Blosc, 1U << 16U}, CodecRow{"crc32c", ZarrCodec::Crc32c, 1},
    CodecRow{"gzip", ZarrCodec::Gzip, 1032},        CodecRow{"lz4", ZarrCodec::Lz4, 256},
    CodecRow{"zlib", ZarrCodec::Zlib, 1032},        CodecRow{"zstd", ZarrCodec::Zstd, 1U << 16U},
};

const CodecRow& rowOf(ZarrCodec codec) {
  return *std::ranges::find(kCodecRows, codec, &CodecRow::codec);
}

Error isDamaged(ZarrCodec codec, std::string_view why) {
  return invalid(fmt::format("its {} data are damaged: {}", rowOf(codec).name, why));
}

Error unpacksTo(std::string_view size, std::uint64_t expected) {
  return invalid(
      fmt::format("unpacks to {} bytes, but a chunk of this array has {}", size, expected));
}

std::uint32_t littleEndian(const char* bytes) {
  std::uint32_t value = 0;
  for (unsigned i = 0; i < 4; ++i) {
    value |= std::uint32_t{static_cast<unsigned char>(bytes[i])} << (8 * i);
  }
  return value;
}

Result<std::string> unpackBlosc(const std::string& packed, std::uint64_t most) {
  std::size_t size = 0;
  if (blosc_cbuffer_validate(packed.data(), packed.size(), &size) != 0) {
    return isDamaged(ZarrCodec::Blosc, "its header contradicts its size");
  }
  if (size > most) return unpacksTo(std::to_string(size), most);
  std::string bytes(size, '\0');
  // Chunks are unpacked in parallel already.
  const int got = blosc_decompress_ctx(packed.data(), bytes.data(), size, 1);
  if (got >= 0 && static_cast<std::size_t>(got) == size) return bytes;
  const char* const library = blosc_cbuffer_complib(packed.data());
  return isDamaged(ZarrCodec::Blosc, fmt::format("{} bytes packed by {} cannot be unpacked", size,
                                                 library != nullptr ? library : "?"));
}

Result<std::string> checkCrc32c(std::string packed) {
  if (packed.size() < 4) return isDamaged(ZarrCodec::Crc32c, "they are cut off");
  const std::size_t size = packed.size() - 4;
  if (system::crc32c(packed.data(), size) != littleEndian(packed.data() + size)) {
    return isDamaged(ZarrCodec::Crc32c, "the checksum is wrong");
  }
  packed.resize(size);
  return packed;
}

/// One member of gzip or several, or a stream of zlib.
Result<std::string> inflate(ZarrCodec codec, std::string& packed, std::uint64_t most) {
  std::string bytes(most, '\0');
  const auto state = std::make_unique<inflate_state>();
  auto* next = reinterpret_cast<std::uint8_t*>(packed.data());
  auto left = static_cast<std::uint32_t>(packed.size());
  std::uint64_t done = 0;
  do {
    isal_inflate_init(state.get());
    state->crc_flag = codec == ZarrCodec::Gzip ? ISAL_GZIP : ISAL_ZLIB;
    state->next_in = next;
    state->avail_in = left;
    state->next_out = reinterpret_cast<std::uint8_t*>(bytes.data()) + done;
    state->avail_out = static_cast<std::uint32_t>(most - done);
    const int result = isal_inflate(state.get());
    system::clearUpperHalves();
    done = most - state->avail_out;
    if (result != ISAL_DECOMP_OK) return isDamaged(codec, "they cannot be unpacked");
    if (state->block_state != ISAL_BLOCK_FINISH) {
      if (state->avail_out == 0) return unpacksTo("more", most);
      return isDamaged(codec, "they are cut off");
    }
    next = state->next_in;
    left = state->avail_in;
  } while (left > 0 && codec == ZarrCodec::Gzip);
  bytes.resize(done);
  return bytes;
}

Result<std::string> unpackZstd(const std::string& packed, std::uint64_t most) {
  std::string bytes(most, '\0');
  const std::size_t got = ZSTD_decompress(bytes.data(), bytes.size(), packed.data(), packed.size());
  if (ZSTD_isError(got) != 0) return isDamaged(ZarrCodec::Zstd, ZSTD_getErrorName(got));
  bytes.resize(got);
  return bytes;
}

/// The size in four bytes, and a block, as numcodecs writes them.
Result<std::string> unpackLz4(const std::string& packed, std::uint64_t most) {
  if (packed.size() < 4) return isDamaged(ZarrCodec::Lz4, "they are cut off");
  const std::uint32_t size = littleEndian(packed.data());
  if (size > most) return unpacksTo(std::to_string(size), most);
  std::string bytes(size, '\0');
  const int got = LZ4_decompress_safe(packed.data() + 4, bytes.data(),
                                      static_cast<int>(packed.size() - 4), static_cast<int>(size));
  if (got < 0 || static_cast<std::uint32_t>(got) != size) {
    return isDamaged(ZarrCodec::Lz4, "they cannot be unpacked");
  }
  return bytes;
}

Result<std::string> unpackOne(ZarrCodec codec, std::string packed, std::uint64_t most) {
  switch (codec) {
    case ZarrCodec::Blosc:
      return unpackBlosc(packed, most);
    case ZarrCodec::Crc32c:
      return checkCrc32c(std::move(packed));
    case ZarrCodec::Lz4:
      return unpackLz4(packed, most);
    case ZarrCodec::Zstd:
      return unpackZstd(packed, most);
    default:
      return inflate(codec, packed, most);
  }
}

}  // namespace

std::optional<ZarrCodec> zarrCodecNamed(std::string_view name) {
  const auto* const found = std::ranges::find(kCodecRows, name, &CodecRow::name);
  return found == kCodecRows.end() ? std::nullopt : std::optional(found->codec);
}

std::string zarrCodecNames() {
  std::string names;
  for (const CodecRow& row : kCodecRows)
    names += fmt::format("{}{}", names.empty() ? "" : ", ", row.name);
  return names;
}

std::uint64_t mostPackedBytes(std::span<const ZarrCodec> codecs, std::uint64_t bytes) {
  constexpr std::uint64_t kOverhead = 1U << 12U;
  for (const ZarrCodec codec : codecs) {
    bytes += codec == ZarrCodec::Crc32c ? 4 : bytes / 64 + kOverhead;
  }
  return bytes;
}

Result<std::string> unpackZarrChunk(std::string packed, std::span<const ZarrCodec> codecs,
                                    std::uint64_t bytes) {
  std::uint64_t most = packed.size();
  for (const ZarrCodec codec : codecs) {
    const std::uint64_t atOnce = rowOf(codec).mostBytes;
    most = most > bytes / atOnce ? std::max(bytes, most) : most * atOnce;
  }
  if (most < bytes) {
    return invalid(fmt::format("has {} bytes, which cannot hold the {} of a chunk of this array",
                               packed.size(), bytes));
  }
  for (std::size_t i = codecs.size(); i-- > 0;) {
    auto unpacked =
        unpackOne(codecs[i], std::move(packed), mostPackedBytes(codecs.first(i), bytes));
    if (!unpacked) return unpacked.error();
    packed = std::move(*unpacked);
  }
  if (packed.size() != bytes) return unpacksTo(std::to_string(packed.size()), bytes);
  return packed;
}

}  // namespace t4d::voxel4d
