#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "t4d/formats/t4d/byte_source.h"
#include "t4d/formats/t4d/chunk_header.h"
#include "t4d/formats/t4d/layout.h"
#include "t4d/model/error.h"

namespace t4d::formats {

/// A payload, checked against its checksums.
struct Payload {
  std::vector<std::byte> bytes;
  t4d_layout::PayloadView view;  ///< points into `bytes`
};

/// A .t4d file as fixed parts and chunks, read at any offset. Every length is checked against the
/// file's size before memory is allocated; every byte read is covered by a checksum or must be
/// zero. Errors name the file and the byte. Reading is safe from several threads at once.
class ChunkFile {
 public:
  static Result<ChunkFile> open(const std::filesystem::path& path);

  const std::string& path() const { return source_->name(); }
  std::uint64_t size() const { return size_; }
  /// Treats the file as truncated after `bytes` bytes.
  void cutAfter(std::uint64_t bytes) { size_ = std::min(size_, bytes); }
  /// Bytes read so far: what a client would have requested from a web server.
  std::uint64_t bytesRead() const { return source_->bytesRead(); }

  struct Header {
    std::uint16_t major = 0;
    std::uint16_t minor = 0;
    bool indexed = false;
    std::vector<std::byte> bytes;  ///< as stored
  };
  Result<Header> readHeader() const;

  struct Footer {
    std::uint64_t index = 0;
    std::uint64_t done = 0;
    std::uint32_t indexChecksum = 0;  ///< of the header of INDX
  };
  Result<Footer> readFooter() const { return readFooter(size_); }
  /// The footer of a file that ends at `end`, which is at most size().
  Result<Footer> readFooter(std::uint64_t end) const;

  /// From now on a chunk must be one of these, in the order of their offsets: what the index says.
  void expectChunks(std::vector<ChunkHeader> chunks) { expected_ = std::move(chunks); }
  Result<ChunkHeader> readChunkHeader(std::uint64_t offset) const;

  /// The first chunk at or after `from` with a valid header, whatever precedes it.
  std::optional<ChunkHeader> findChunk(std::uint64_t from) const;

  /// The payload of the chunk, after checking its checksums and padding.
  Result<Payload> readPayload(const ChunkHeader& header) const;

  /// Header and payload of a chunk, which must be of `type`.
  struct Chunk {
    ChunkHeader header;
    Payload payload;
  };
  Result<Chunk> readChunk(std::uint64_t offset, t4d_layout::ChunkType type) const;

  /// An error in this file at `offset`.
  tl::unexpected<Error> damaged(std::uint64_t offset, const std::string& message,
                                ErrorCode code = ErrorCode::InvalidInput) const;

 private:
  explicit ChunkFile(std::unique_ptr<ByteSource> source)
      : source_(std::move(source)), size_(source_->size()) {}
  Result<std::vector<std::byte>> read(std::uint64_t offset, std::uint64_t bytes) const;
  /// Parses the 24 bytes at `offset`.
  Result<ChunkHeader> chunkHeader(std::uint64_t offset, std::span<const std::byte> bytes) const;

  std::unique_ptr<ByteSource> source_;
  std::uint64_t size_ = 0;
  std::optional<std::vector<ChunkHeader>> expected_;
};

}  // namespace t4d::formats
