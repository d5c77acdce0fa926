#include "t4d/formats/t4d/chunk_list.h"

#include <cstring>
#include <span>

#include "t4d/formats/t4d/crc32c.h"

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
  const std::uint32_t crc = crc32c(file.data() + from, size);
  std::memcpy(file.data() + to, &crc, sizeof crc);
}

}  // namespace

std::vector<ChunkHeader> listChunks(std::string_view file) {
  std::vector<ChunkHeader> chunks;
  const std::size_t end = endOfChunks(file);
  std::size_t at = kFileHeaderBytes;
  while (at < end && end - at >= kChunkHeaderBytes) {
    ByteReader bytes(std::as_bytes(std::span(file)).subspan(at, kChunkHeaderBytes));
    ChunkHeader chunk;
    for (char& letter : chunk.type) letter = bytes.take<char>();
    chunk.flags = bytes.take<std::uint32_t>();
    chunk.payloadBytes = bytes.take<std::uint64_t>();
    chunk.payloadCrc = bytes.take<std::uint32_t>();
    chunk.offset = at;
    const std::size_t left = end - chunk.payload();
    if (chunk.payloadBytes > left || padded(chunk.payloadBytes) > left) break;
    at = chunk.end();
    chunks.push_back(chunk);
  }
  return chunks;
}

void repairChecksums(std::string& file) {
  constexpr std::size_t kCoveredByHeader = 20;
  const auto repairHeader = [&](std::size_t at) {
    if (file.size() - at < kChunkHeaderBytes) return;
    putChecksum(file, at + kCoveredByHeader, at, kCoveredByHeader);
  };
  if (file.size() < kFileHeaderBytes) return;
  putChecksum(file, kCoveredByHeader, 0, kCoveredByHeader);
  std::size_t end = kFileHeaderBytes;
  for (const ChunkHeader& chunk : listChunks(file)) {
    putChecksum(file, chunk.offset + 16, chunk.payload(), chunk.payloadBytes);
    repairHeader(chunk.offset);
    end = chunk.end();
  }
  const std::size_t footer = endOfChunks(file);
  if (end < footer) repairHeader(end);  // of a chunk whose length is false
  if (footer < file.size()) putChecksum(file, footer + 28, footer, 28);
}

}  // namespace t4d::formats
