#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "platform/part_file.h"
#include "t4d/error.h"

namespace t4d::formats {

/// A file that appears whole or not at all (platform::PartFile), written through a buffer. It gets
/// its name by `commit`.
class OutputFile {
 public:
  static Result<OutputFile> create(const std::filesystem::path& target);

  OutputFile(OutputFile&&) noexcept = default;
  OutputFile& operator=(OutputFile&&) noexcept = default;

  /// Appends; errors name the target and the system's reason (a full disk, say).
  Result<void> write(const void* data, std::size_t size);

  /// Replaces bytes that were written before. Fails if the target is a pipe.
  Result<void> rewrite(std::uint64_t offset, const void* data, std::size_t size);

  /// Bytes written so far.
  std::uint64_t size() const { return size_; }

  /// Flushes everything to the disk and gives the file its name.
  Result<void> commit() { return commitAll({this, 1}); }

  /// Writes these bytes and commits.
  Result<void> finish(std::string_view bytes);

  /// Commits files of one folder, all or none (platform::PartFile::putInPlace).
  static Result<void> commitAll(std::span<OutputFile> files);

 private:
  explicit OutputFile(platform::PartFile part);
  Result<void> flush();

  platform::PartFile part_;
  std::uint64_t size_ = 0;
  std::string buffer_;
};

/// Writes a file that has these bytes.
Result<void> writeOutputFile(const std::filesystem::path& target, std::string_view bytes);

}  // namespace t4d::formats
