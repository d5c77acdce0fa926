#include "formats/t4d/chunk_list.h"

#include <algorithm>
#include <cstring>
#include <span>

#include "platform/crc32c.h"

namespace t4d::formats {

using namespace t4d_layout;

namespace {

std::size_t endOfChunks(std::string_view file) {
  const bool hasFooter = file.size() >= kFileHeaderBytes + kFooterBytes &&
                         std::memcmp(file.data() + file.size() - kEndSignature.size(),
                                     kEndSignature.data(), kEndSignature.size()) == 0;
  return file.size() - (hasFooter ? kFooterBytes : 0);
}

/// Stores the checksum of `[from, from + size)` at `to`.
void putChecksum(std::string& file, std::size_t to, std::size_t from, std::size_t size) {
  const std::uint32_t crc = platform::crc32c(file.data() + from, size);
  std::memcpy(file.data() + to, &crc, sizeof crc);
}

/// Sets the checksums of blocks, as far as their table is within the front and they are within the
/// payload.
void repairBlocks(std::string& file, const ChunkHeader& chunk) {
  std::uint64_t at = chunk.frontBytes;
  for (std::uint64_t i = 0; i < chunk.blocks; ++i) {
    const std::uint64_t entry = i * kBlockEntryBytes;
    if (entry + kBlockEntryBytes > std::min<std::uint64_t>(chunk.frontBytes, chunk.payloadBytes)) {
      return;
    }
    std::uint32_t size = 0;
    std::memcpy(&size, file.data() + chunk.payload() + entry, sizeof size);
    if (at > chunk.payloadBytes || size > chunk.payloadBytes - at) return;
    putChecksum(file, chunk.payload() + entry + sizeof size, chunk.payload() + at, size);
    at += padded(size);
  }
}

}  // namespace

std::vector<ChunkHeader> listChunks(std::string_view file) {
  std::vector<ChunkHeader> chunks;
  const std::size_t end = endOfChunks(file);
  std::size_t at = kFileHeaderBytes;
  while (at < end && end - at >= kChunkHeaderBytes) {
    const ChunkHeader chunk = decodeChunkHeader(
        std::as_bytes(std::span(file)).subspan(at).first<kDirectoryEntryBytes>(), at);
    const std::size_t left = end - chunk.payload();
    if (chunk.payloadBytes > left || padded(chunk.payloadBytes) > left) break;
    at = chunk.end();
    chunks.push_back(chunk);
  }
  return chunks;
}

void repairChecksums(std::string& file) {
  const auto repairHeader = [&](std::size_t at) {
    constexpr std::size_t kCovered = 28;
    if (file.size() - at < kChunkHeaderBytes) return;
    putChecksum(file, at + kCovered, at, kCovered);
  };
  if (file.size() < kFileHeaderBytes) return;
  putChecksum(file, 20, 0, 20);
  std::size_t end = kFileHeaderBytes;
  for (const ChunkHeader& chunk : listChunks(file)) {
    repairBlocks(file, chunk);
    const std::uint64_t front = std::min<std::uint64_t>(chunk.frontBytes, chunk.payloadBytes);
    putChecksum(file, chunk.offset + 24, chunk.payload(), front);
    repairHeader(chunk.offset);
    end = chunk.end();
  }
  const std::size_t footer = endOfChunks(file);
  if (end < footer) repairHeader(end);  // of a chunk whose length is false
  // The footer's checksum of INDX, which has its own only now.
  for (const ChunkHeader& chunk : listChunks(file)) {
    if (chunk.type != kIndex || footer == file.size()) continue;
    std::memcpy(file.data() + footer + 24, file.data() + chunk.offset + 28, 4);
  }
  if (footer < file.size()) putChecksum(file, footer + 28, footer, 28);
}

}  // namespace t4d::formats
