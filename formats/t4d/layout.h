#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "formats/t4d/stored_block.h"
#include "t4d/file.h"

/// The byte layout of .t4d, as specified in formats/t4d/SPEC.md. Reader and writer share these
/// constants.
namespace t4d::formats::t4d_layout {

static_assert(std::endian::native == std::endian::little,
              "arrays are copied between memory and little-endian files");

inline constexpr std::uint16_t kMajorVersion = 1;
inline constexpr std::uint16_t kMinorVersion = 1;

inline constexpr std::array<std::uint8_t, 8> kSignature = {0x89, 'T',  '4',  'D',
                                                           0x0D, 0x0A, 0x1A, 0x0A};
inline constexpr std::array<std::uint8_t, 8> kEndSignature = {0x0A, 0x1A, 0x0A, 0x0D,
                                                              'D',  '4',  'T',  0x89};

inline constexpr std::size_t kFileHeaderBytes = 24;
/// The file header without its checksum, as in INDX.
inline constexpr std::size_t kFileHeaderCopyBytes = 20;
inline constexpr std::size_t kChunkHeaderBytes = 32;
inline constexpr std::size_t kFooterBytes = 40;
/// A chunk header without its checksum, as in the directory of INDX.
inline constexpr std::size_t kDirectoryEntryBytes = 28;
inline constexpr std::size_t kBlockEntryBytes = 8;
inline constexpr std::size_t kArrayHeaderBytes = 16;
inline constexpr std::size_t kBodySummaryBytes = 88;
inline constexpr std::size_t kAlignment = 8;

inline constexpr std::uint32_t kFlagIndexed = 1;   // file flag
inline constexpr std::uint32_t kFlagCritical = 1;  // chunk flag

using ChunkType = std::array<char, 4>;
inline constexpr ChunkType kHead = {'H', 'E', 'A', 'D'};
inline constexpr ChunkType kConnectivity = {'C', 'O', 'N', 'N'};
inline constexpr ChunkType kLayer = {'L', 'A', 'Y', 'R'};
inline constexpr ChunkType kPose = {'P', 'O', 'S', 'E'};
inline constexpr ChunkType kSlab = {'S', 'L', 'A', 'B'};
inline constexpr ChunkType kDone = {'D', 'O', 'N', 'E'};
inline constexpr ChunkType kIndex = {'I', 'N', 'D', 'X'};
inline constexpr ChunkType kPadding = {'P', 'A', 'D', 'D'};
inline constexpr ChunkType kPage = {'P', 'A', 'G', 'E'};
inline constexpr ChunkType kPageList = {'P', 'G', 'I', 'X'};

inline constexpr std::uint64_t kMaxHeadBytes = std::uint64_t{16} << 20;
inline constexpr std::size_t kMaxNameBytes = 255;
inline constexpr std::uint64_t kMaxBodies = 65536;
/// A chunk names one of the last chunks of a type, this many for each body.
inline constexpr std::size_t kWindowPerBody = 16;
inline constexpr int kMaxJsonDepth = 64;
/// An array is stored in blocks of this many rows; the last may have fewer.
inline constexpr std::uint64_t kBlockRows = 65536;
inline constexpr std::uint64_t blockCount(std::uint64_t rows) {
  return rows / kBlockRows + (rows % kBlockRows != 0);
}
/// A compressed block unpacks to at most this many times its stored size.
inline constexpr std::uint64_t kMaxExpansion = 1024;

inline constexpr std::string_view kFeatureZstd = "zstd";
inline constexpr std::string_view kFeatureMeans = "means";
inline constexpr std::string_view kFeaturePose = "pose";
inline constexpr std::string_view kFeatureGrid = "grid";
inline constexpr std::array kFeatures = {kFeatureZstd, kFeatureMeans, kFeaturePose, kFeatureGrid};

/// The features that a file names in HEAD. It may use no others.
struct Features {
  bool zstd = true;
  bool means = true;
  bool pose = true;
  std::optional<Grid> grid = {};
};

inline constexpr std::uint64_t padded(std::uint64_t bytes) {
  return (bytes + kAlignment - 1) / kAlignment * kAlignment;
}

/// Appends little-endian values.
class ByteWriter {
 public:
  template <class T>
  void put(T value) {
    static_assert(std::is_arithmetic_v<T>);
    putBytes(&value, sizeof value);
  }
  void putBytes(const void* data, std::size_t size) {
    const auto* from = static_cast<const std::byte*>(data);
    bytes_.insert(bytes_.end(), from, from + size);
  }
  void pad() { bytes_.resize(padded(bytes_.size())); }

  const std::byte* data() const { return bytes_.data(); }
  std::size_t size() const { return bytes_.size(); }
  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
};

/// The payload of a chunk without the table of its blocks: fields, and the contents of arrays.
struct PayloadView {
  std::span<const std::byte> fields;
  std::vector<std::span<const std::byte>> blocks;
};

/// A payload to be written: its fields, and its blocks.
class PayloadWriter : public ByteWriter {
 public:
  void putBlock(StoredBlock block) { blocks_.push_back(std::move(block)); }
  /// Appends the fields and the blocks of another payload.
  void append(PayloadWriter other) {
    putBytes(other.data(), other.size());
    std::ranges::move(other.blocks_, std::back_inserter(blocks_));
  }
  const std::vector<StoredBlock>& blocks() const { return blocks_; }
  /// A view of the payload, whose blocks must be in memory; valid until the next change.
  PayloadView view() const {
    PayloadView view{bytes(), {}};
    for (const StoredBlock& block : blocks_) view.blocks.push_back(block.bytes());
    return view;
  }

 private:
  std::vector<StoredBlock> blocks_;
};

/// Reads little-endian values. Never reads past the end; overrun() says whether that was attempted.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <class T>
  T take() {
    static_assert(std::is_arithmetic_v<T>);
    T value{};
    const auto from = takeBytes(sizeof value);
    if (from.size() == sizeof value) std::memcpy(&value, from.data(), sizeof value);
    return value;
  }
  /// Empty if fewer than `size` bytes are left.
  std::span<const std::byte> takeBytes(std::uint64_t size) {
    if (size > left()) {
      overrun_ = true;
      at_ = bytes_.size();
      return {};
    }
    const auto taken = bytes_.subspan(at_, size);
    at_ += size;
    return taken;
  }
  /// Skips to the next multiple of 8; false if a skipped byte is not zero.
  bool skipPadding() {
    for (const std::byte byte : takeBytes(padded(at_) - at_)) {
      if (byte != std::byte{0}) return false;
    }
    return !overrun_;
  }
  std::size_t position() const { return at_; }
  std::size_t left() const { return bytes_.size() - at_; }
  bool overrun() const { return overrun_; }

 private:
  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
  bool overrun_ = false;
};

/// Reads the fields of a payload, and its blocks in order.
class PayloadReader : public ByteReader {
 public:
  explicit PayloadReader(const PayloadView& payload)
      : ByteReader(payload.fields), blocks_(payload.blocks) {}

  std::size_t blocksLeft() const { return blocks_.size() - next_; }
  /// `count` is at most blocksLeft().
  std::span<const std::span<const std::byte>> takeBlocks(std::size_t count) {
    next_ += count;
    return std::span(blocks_).subspan(next_ - count, count);
  }

 private:
  std::span<const std::span<const std::byte>> blocks_;
  std::size_t next_ = 0;
};

}  // namespace t4d::formats::t4d_layout
