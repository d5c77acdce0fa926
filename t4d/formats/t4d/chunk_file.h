#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "t4d/formats/t4d/layout.h"
#include "t4d/model/error.h"

namespace t4d::formats {

/// The header of a chunk, and its offset.
struct ChunkHeader {
  t4d_layout::ChunkType type{};
  std::uint32_t flags = 0;
  std::uint64_t payloadBytes = 0;
  std::uint32_t payloadCrc = 0;
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
};

/// A .t4d file as fixed parts and chunks, read at any offset. Every length is checked against the
/// file's size before memory is allocated; every byte read is covered by a checksum or must be
/// zero. Errors name the file and the byte. Reading is safe from several threads at once.
class ChunkFile {
 public:
  static Result<ChunkFile> open(const std::filesystem::path& path);

  ChunkFile(ChunkFile&& other) noexcept;
  ChunkFile& operator=(ChunkFile&& other) noexcept;
  ~ChunkFile();

  const std::string& path() const { return path_; }
  std::uint64_t size() const { return size_; }
  /// Treats the file as truncated after `bytes` bytes.
  void cutAfter(std::uint64_t bytes) { size_ = std::min(size_, bytes); }
  /// Bytes read so far: what a client would have requested from a web server.
  std::uint64_t bytesRead() const { return bytesRead_; }

  struct Header {
    std::uint16_t major = 0;
    std::uint16_t minor = 0;
    bool indexed = false;
  };
  Result<Header> readHeader() const;

  struct Footer {
    std::uint64_t index = 0;
    std::uint64_t done = 0;
  };
  Result<Footer> readFooter() const { return readFooter(size_); }
  /// The footer of a file that ends at `end`, which is at most size().
  Result<Footer> readFooter(std::uint64_t end) const;

  Result<ChunkHeader> readChunkHeader(std::uint64_t offset) const;

  /// The first chunk at or after `from` with a valid header, whatever precedes it.
  std::optional<ChunkHeader> findChunk(std::uint64_t from) const;

  /// The payload of the chunk, after checking its checksum and padding.
  Result<std::vector<std::byte>> readPayload(const ChunkHeader& header) const;

  /// Header and payload of a chunk, which must be of `type`.
  struct Chunk {
    ChunkHeader header;
    std::vector<std::byte> payload;
  };
  Result<Chunk> readChunk(std::uint64_t offset, t4d_layout::ChunkType type) const;

  /// An error in this file at `offset`.
  tl::unexpected<Error> damaged(std::uint64_t offset, const std::string& message,
                                ErrorCode code = ErrorCode::InvalidInput) const;

 private:
  ChunkFile() = default;
  Result<std::vector<std::byte>> read(std::uint64_t offset, std::uint64_t bytes) const;
  /// Parses the 24 bytes at `offset`.
  Result<ChunkHeader> chunkHeader(std::uint64_t offset, std::span<const std::byte> bytes) const;

  std::string path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
  mutable std::atomic<std::uint64_t> bytesRead_ = 0;
};

}  // namespace t4d::formats
