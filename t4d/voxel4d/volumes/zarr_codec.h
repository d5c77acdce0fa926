#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "t4d/model/error.h"

namespace t4d::voxel4d {

/// How bytes of a chunk are packed.
enum class ZarrCodec : std::uint8_t { Blosc, Crc32c, Gzip, Lz4, Zlib, Zstd };

/// By the name of a codec, such as "zstd"; nothing for another.
std::optional<ZarrCodec> zarrCodecNamed(std::string_view name);
/// "blosc, crc32c, ...".
std::string zarrCodecNames();

/// Unpacks a chunk that was packed by one codec after another. Fails unless there are `bytes`
/// afterwards, for what is damaged, and before anything is allocated where so few bytes cannot hold
/// as many. The error does not say where.
Result<std::string> unpackZarrChunk(std::string packed, std::span<const ZarrCodec> codecs,
                                    std::uint64_t bytes);

/// The maximum packed size that is plausible for a chunk of this many bytes.
std::uint64_t mostPackedBytes(std::span<const ZarrCodec> codecs, std::uint64_t bytes);

}  // namespace t4d::voxel4d
