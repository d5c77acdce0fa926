#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/t4d/byte_source.h"
#include "formats/t4d/chunk_header.h"
#include "formats/t4d/layout.h"
#include "t4d/error.h"

namespace t4d::formats {

/// A payload, checked against its checksums.
struct Payload {
  std::vector<std::byte> bytes;
  t4d_layout::PayloadView view;  ///< points into `bytes`
};

class ChunkFile;

/// A payload of which blocks are read when they are needed.
class PartialPayload {
 public:
  PartialPayload() = default;

  const ChunkHeader& header() const { return header_; }
  /// Only the places of the blocks are known before they are loaded.
  const t4d_layout::PayloadView& view() const { return view_; }
  /// Reads one of the blocks, unless it has been, and checks it. Safe from several threads at once.
  Result<void> load(std::span<const std::byte> block) const;

 private:
  friend class ChunkFile;
  struct Loaded {
    std::mutex mutex;
    std::vector<bool> blocks;
  };

  const ChunkFile* file_ = nullptr;
  ChunkHeader header_;
  /// The bytes of the whole payload; what has not been read takes no memory.
  std::unique_ptr<std::byte[]> bytes_;
  t4d_layout::PayloadView view_;
  std::unique_ptr<Loaded> loaded_;
};

/// A .t4d file as fixed parts and chunks, read at any offset. Every length is checked against the
/// file's size before memory is allocated; every byte read is covered by a checksum or must be
/// zero. Errors name the file and the byte. Reading is safe from several threads at once.
class ChunkFile {
 public:
  /// Opens what openByteSource opens.
  static Result<ChunkFile> open(const std::filesystem::path& pathOrUrl);
  explicit ChunkFile(std::shared_ptr<ByteSource> source) : source_(std::move(source)) {}

  const std::string& path() const { return source_->name(); }
  bool remote() const { return source_->remote(); }
  /// The size, as ByteSource::size has it.
  std::uint64_t size() const { return std::min(source_->size(), cut_); }
  /// The number of bytes that are known to exist.
  std::uint64_t knownBytes() const {
    return size() == ByteSource::kUnknownSize ? bytesRead() : size();
  }
  /// Treats the file as truncated after `bytes` bytes.
  void cutAfter(std::uint64_t bytes) { cut_ = std::min(cut_, bytes); }
  /// Bytes read so far: what a client would have requested from a web server.
  std::uint64_t bytesRead() const { return source_->bytesRead(); }
  std::uint64_t requests() const { return source_->requests(); }

  struct Header {
    std::uint16_t major = 0;
    std::uint16_t minor = 0;
    bool indexed = false;
    std::array<std::byte, t4d_layout::kFileHeaderCopyBytes> bytes{};  ///< as stored, no checksum
  };
  Result<Header> readHeader() const;
  /// Parses a copy of the header, which has no checksum.
  Result<Header> decodeHeader(
      std::span<const std::byte, t4d_layout::kFileHeaderCopyBytes> copy) const;

  struct Footer {
    std::uint64_t index = 0;
    std::uint64_t done = 0;
    std::uint32_t indexChecksum = 0;  ///< of the header of INDX
  };
  Result<Footer> readFooter() const { return readFooter(size()); }
  /// The footer of a file that ends at `end`, which is at most size().
  Result<Footer> readFooter(std::uint64_t end) const;

  /// Requires each chunk that is read from now on to be one of these, sorted by offset: those of
  /// the index, or those found before.
  void expectChunks(std::vector<ChunkHeader> chunks);
  /// A copy that also requires a chunk at the offset of one of these to be that chunk.
  ChunkFile withChunks(std::vector<ChunkHeader> chunks) const;
  Result<ChunkHeader> readChunkHeader(std::uint64_t offset) const;

  /// The number before `end`: the size of a list of pages, if there is one.
  Result<std::uint64_t> readLength(std::uint64_t end) const;

  /// The range of the chunk at `offset`, as far as expectChunks says so; empty otherwise.
  ByteRange placeOf(std::uint64_t offset) const;
  /// The place of the LAYR that a POSE at `offset` is likely to move: the last before it. Known of
  /// remote files only, and empty otherwise.
  ByteRange likelyLayerOf(std::uint64_t offset) const;
  /// Calls ByteSource::plan.
  void plan(std::span<const ByteRange> ranges) const { source_->plan(ranges); }

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

  /// A chunk of `type`, of which only the front is read; valid as long as the file.
  Result<PartialPayload> readPartly(std::uint64_t offset, t4d_layout::ChunkType type) const;

  /// An error in this file at `offset`.
  Error damaged(std::uint64_t offset, const std::string& message,
                ErrorCode code = ErrorCode::InvalidInput) const;

 private:
  friend class PartialPayload;

  Result<std::vector<std::byte>> read(std::uint64_t offset, std::uint64_t bytes) const;
  Result<ChunkHeader> headerOf(std::uint64_t offset, t4d_layout::ChunkType type) const;
  /// The error of a payload, whose offset is one in it.
  Error damagedIn(const ChunkHeader& header, const Error& error) const;
  /// Parses the 24 bytes at `offset`.
  Result<ChunkHeader> chunkHeader(std::uint64_t offset, std::span<const std::byte> bytes) const;

  std::shared_ptr<ByteSource> source_;
  std::uint64_t cut_ = ~std::uint64_t{0};
  std::optional<std::vector<ChunkHeader>> expected_;
  bool expectsOthers_ = false;
  std::vector<ByteRange> layers_;  // the LAYRs among them
};

}  // namespace t4d::formats
