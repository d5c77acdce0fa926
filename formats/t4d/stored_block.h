#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "platform/scratch_file.h"
#include "t4d/error.h"

namespace t4d::formats {

/// Blocks that wait in a temporary file until their chunk is written.
class BlockFile {
 public:
  /// Puts bytes at the end and returns their offset; nothing where there is no room on the disk, or
  /// no file could be made. Several threads may call it at a time.
  std::optional<std::uint64_t> add(std::span<const std::byte> bytes);

  bool read(std::uint64_t offset, std::span<std::byte> into) const;

 private:
  std::mutex mutex_;
  std::optional<platform::ScratchFile> file_;
  bool failed_ = false;
  std::uint64_t size_ = 0;
};

/// A block of a payload that is to be written: in memory, or in a file.
class StoredBlock {
 public:
  StoredBlock() = default;
  explicit StoredBlock(std::vector<std::byte> bytes);

  /// Moves the bytes to the file, if that takes them.
  void moveTo(const std::shared_ptr<BlockFile>& file);

  std::size_t size() const { return size_; }
  std::uint32_t checksum() const { return checksum_; }

  /// The bytes; `space` is used for those of a file.
  Result<std::span<const std::byte>> bytes(std::vector<std::byte>& space) const;
  /// The bytes of a block in memory.
  std::span<const std::byte> bytes() const { return bytes_; }

  /// Whether both are in memory and the same.
  friend bool operator==(const StoredBlock& a, const StoredBlock& b) {
    return !a.file_ && !b.file_ && a.bytes_ == b.bytes_;
  }

 private:
  std::vector<std::byte> bytes_;
  std::size_t size_ = 0;
  std::uint32_t checksum_ = 0;
  std::shared_ptr<const BlockFile> file_;
  std::uint64_t offset_ = 0;
};

}  // namespace t4d::formats
