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

/// The beginning of a chunk, and where it is.
struct ChunkHeader {
  t4d_layout::ChunkType type{};
  std::uint32_t flags = 0;
  std::uint64_t payloadBytes = 0;
  std::uint32_t payloadCrc = 0;
  std::uint64_t offset = 0;

  std::string name() const { return {type.begin(), type.end()}; }
  bool critical() const { return (flags & t4d_layout::kFlagCritical) != 0; }
  /// The chunk's bytes in the file, with header and padding.
  std::uint64_t bytes() const {
    return t4d_layout::kChunkHeaderBytes + t4d_layout::padded(payloadBytes);
  }
  std::uint64_t end() const { return offset + bytes(); }
};

/// A .t4d file as fixed parts and chunks, read at any offset. Every length is held against the
/// file's size before memory is asked for; every byte read is covered by a checksum or must be
/// zero. Errors name the file and the byte. Reading is safe from several threads at once.
class ChunkFile {
 public:
  static Result<ChunkFile> open(const std::filesystem::path& path);

  ChunkFile(ChunkFile&& other) noexcept;
  ChunkFile& operator=(ChunkFile&& other) noexcept;
  ~ChunkFile();

  const std::string& path() const { return path_; }
  std::uint64_t size() const { return size_; }
  /// Takes the file as one that was cut off after so many bytes.
  void cutAfter(std::uint64_t bytes) { size_ = std::min(size_, bytes); }
  /// Bytes read so far: what a client of a web server would have asked it for.
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
  /// Of a file that ends at `end`, at most size().
  Result<Footer> readFooter(std::uint64_t end) const;

  Result<ChunkHeader> readChunkHeader(std::uint64_t offset) const;

  /// The first chunk at or after `from` whose header is right, whatever lies before it.
  std::optional<ChunkHeader> findChunk(std::uint64_t from) const;

  /// The payload of the chunk, its checksum and padding checked.
  Result<std::vector<std::byte>> readPayload(const ChunkHeader& header) const;

  /// Header and payload of a chunk that must be of `type`.
  struct Chunk {
    ChunkHeader header;
    std::vector<std::byte> payload;
  };
  Result<Chunk> readChunk(std::uint64_t offset, t4d_layout::ChunkType type) const;

  /// An error of this file at a byte.
  tl::unexpected<Error> damaged(std::uint64_t offset, const std::string& message,
                                ErrorCode code = ErrorCode::InvalidInput) const;

 private:
  ChunkFile() = default;
  Result<std::vector<std::byte>> read(std::uint64_t offset, std::uint64_t bytes) const;
  /// Takes the 24 bytes at `offset` apart.
  Result<ChunkHeader> chunkHeader(std::uint64_t offset, std::span<const std::byte> bytes) const;

  std::string path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
  mutable std::atomic<std::uint64_t> bytesRead_ = 0;
};

}  // namespace t4d::formats
