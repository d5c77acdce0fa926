#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "platform/descriptor.h"
#include "t4d/error.h"

namespace t4d::platform {

/// A file that is open for reading, and noted as an input of the run (kept_inputs.h). Errors name
/// the file and the system's reason.
class OpenFile {
 public:
  /// Opens any file but a folder; `-` is the standard input. Opening a pipe waits for its writer.
  static Result<OpenFile> open(const std::filesystem::path& path);
  /// Opens a regular file. Fails for any other at once, with the message `notRegular`.
  static Result<OpenFile> openRegular(const std::filesystem::path& path,
                                      const char* notRegular = "is not a regular file");

  /// Its name in messages.
  const std::string& name() const { return name_; }
  /// Its bytes when it was opened; 0 for what has no size.
  std::uint64_t size() const { return size_; }
  /// Differs between two contents of a name: made of the file's number, size and time of change.
  const std::string& version() const { return version_; }

  /// Waits for the next bytes and puts them at the beginning of `into`. Returns how many: 0 at the
  /// end.
  Result<std::size_t> read(std::span<std::byte> into);
  /// Sets `into` to the bytes from `offset` on. Returns how many there are: fewer only at the end.
  /// Safe to call from several threads at once.
  Result<std::size_t> readAt(std::uint64_t offset, std::span<std::byte> into) const;
  /// Sets where `read` goes on.
  void seek(std::uint64_t offset);

 private:
  OpenFile(Descriptor descriptor, std::string name)
      : descriptor_(std::move(descriptor)), name_(std::move(name)) {}
  static Result<OpenFile> opened(Descriptor descriptor, std::string name, const char* notRegular);

  Descriptor descriptor_;
  std::string name_;
  std::uint64_t size_ = 0;
  std::string version_;
};

}  // namespace t4d::platform
