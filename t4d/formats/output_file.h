#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "t4d/model/error.h"
#include "t4d/system/part_file.h"

namespace t4d::formats {

/// A file that appears whole or not at all: bytes go to a part file (system::PartFile), which
/// `commit` renames. Without `commit` the part file is removed. A target that is a device or a pipe
/// is written to directly, and so is the standard output, whose name is `-`; a symbolic link is
/// followed.
class OutputFile {
 public:
  static Result<OutputFile> create(const std::filesystem::path& target);

  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&& other) noexcept;
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile() { close(); }

  /// A file that is there and stays there, for `rewrite` alone; `commit` waits until it is on disk.
  /// Several processes can have it open, unless one has it alone (on file systems with locks).
  enum class Sharing : char { Shared, Alone };
  static Result<OutputFile> openToRewrite(const std::filesystem::path& file, Sharing sharing);

  /// Appends; errors name the target and the system's reason (a full disk, say).
  Result<void> write(const void* data, std::size_t size);

  /// Replaces bytes that were written before. Fails if the target is a pipe.
  Result<void> rewrite(std::uint64_t offset, const void* data, std::size_t size);

  /// Reserves space for this many bytes, to be written by `rewrite` or by another process. Fails if
  /// the target is a pipe.
  Result<void> skip(std::uint64_t bytes);

  /// Bytes written so far.
  std::uint64_t size() const { return size_; }

  /// Flushes everything to the disk and gives the file its name.
  Result<void> commit() { return commitAll({this, 1}); }

  /// Writes these bytes and commits.
  Result<void> finish(std::string_view bytes);

  /// Commits files of one folder, all or none (system::PartFile::putInPlace).
  static Result<void> commitAll(std::span<OutputFile> files);

 private:
  OutputFile() = default;
  Result<void> flush();
  void close() noexcept;

  std::filesystem::path target_;
  system::PartFile part_;  // none when written to directly
  int descriptor_ = -1;
  bool stays_ = false;  // was there before
  std::uint64_t size_ = 0;
  std::vector<std::byte> buffer_;
};

/// Follows symbolic links to their target, which need not exist. Returns any other path unchanged.
std::filesystem::path followLinks(std::filesystem::path target);

/// Writes a file that has these bytes.
Result<void> writeOutputFile(const std::filesystem::path& target, std::string_view bytes);

}  // namespace t4d::formats
