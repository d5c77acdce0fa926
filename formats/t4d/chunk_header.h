#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "formats/t4d/layout.h"
#include "t4d/error.h"

namespace t4d::formats {

/// The header of a chunk, and its offset in the file (SPEC.md, section "Chunks").
struct ChunkHeader {
  t4d_layout::ChunkType type{};
  std::uint32_t flags = t4d_layout::kFlagCritical;
  std::uint64_t payloadBytes = 0;
  std::uint32_t frontBytes = 0;  ///< of the payload before its blocks: their table, and fields
  std::uint32_t blocks = 0;
  std::uint32_t frontCrc = 0;
  std::uint64_t offset = 0;

  std::string name() const { return {type.begin(), type.end()}; }
  bool critical() const { return (flags & t4d_layout::kFlagCritical) != 0; }
  /// Size of the chunk in the file, including header and padding.
  std::uint64_t bytes() const {
    return t4d_layout::kChunkHeaderBytes + t4d_layout::padded(payloadBytes);
  }
  std::uint64_t end() const { return offset + bytes(); }
  /// Offset of the payload in the file.
  std::uint64_t payload() const { return offset + t4d_layout::kChunkHeaderBytes; }
  /// Offset of its fields, after the table of blocks.
  std::uint64_t fields() const { return payload() + blocks * t4d_layout::kBlockEntryBytes; }

  friend bool operator==(const ChunkHeader&, const ChunkHeader&) = default;
};

/// A header as stored.
using ChunkHeaderBytes = std::array<std::byte, t4d_layout::kChunkHeaderBytes>;

/// The bytes of a header with its checksum.
ChunkHeaderBytes encodeChunkHeader(const ChunkHeader& header);

/// The checksum that encodeChunkHeader puts at the end.
std::uint32_t checksumOf(const ChunkHeader& header);

/// Whether the checksum at the end of the stored header is right.
bool hasRightChecksum(std::span<const std::byte, t4d_layout::kChunkHeaderBytes> bytes);

/// Decodes a stored header without checking anything, including its checksum.
ChunkHeader decodeChunkHeader(std::span<const std::byte, t4d_layout::kDirectoryEntryBytes> bytes,
                              std::uint64_t offset);

/// A chunk to be written: its header, and the front of its payload; the blocks follow, each with
/// its padding.
struct ChunkFront {
  ChunkHeader header;
  t4d_layout::ByteWriter front;
};
ChunkFront frontOf(t4d_layout::ChunkType type, const t4d_layout::PayloadWriter& payload,
                   std::uint64_t offset, std::uint32_t flags = t4d_layout::kFlagCritical);

/// Takes a payload apart, which may be followed by the padding of the chunk. Fails if a checksum or
/// a padding is wrong; the error has the offset in the payload.
Result<t4d_layout::PayloadView> payloadOf(const ChunkHeader& header,
                                          std::span<const std::byte> payload);

/// Checks the front of a payload against its checksum, and the sizes of blocks in it.
Result<void> checkFront(const ChunkHeader& header, std::span<const std::byte> front);

/// Finds the blocks of a payload of which only the front has been read. Otherwise like payloadOf.
Result<t4d_layout::PayloadView> placesOf(const ChunkHeader& header,
                                         std::span<const std::byte> payload);
/// Checks the checksum and the padding of block `number`.
Result<void> checkBlock(const ChunkHeader& header, std::span<const std::byte> payload,
                        const t4d_layout::PayloadView& view, std::uint32_t number);

}  // namespace t4d::formats
