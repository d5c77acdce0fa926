#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "t4d/error.h"

namespace t4d::platform {

/// A file without a name, in the folder for temporary files (TMPDIR), for data that need not stay
/// in memory. It disappears with the object, or with the process, however that ends.
class ScratchFile {
 public:
  static Result<ScratchFile> create();

  ScratchFile(ScratchFile&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  ScratchFile& operator=(ScratchFile&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  ~ScratchFile();

  /// Appends bytes.
  Result<void> append(std::span<const std::byte> bytes);

  /// Sets `into` to the bytes from `offset` on. Safe to call from several threads at once. False if
  /// they cannot be read, because they were not written or the disk fails.
  bool read(std::uint64_t offset, std::span<std::byte> into) const;

 private:
  explicit ScratchFile(int descriptor) : descriptor_(descriptor) {}
  int descriptor_ = -1;
};

}  // namespace t4d::platform
