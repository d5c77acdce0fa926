#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "platform/descriptor.h"
#include "t4d/error.h"

namespace t4d::platform {

/// A file without a name, in the folder for temporary files (TMPDIR), for data that need not stay
/// in memory. It disappears with the object, or with the process, however that ends.
class ScratchFile {
 public:
  static Result<ScratchFile> create();

  /// Appends bytes.
  Result<void> append(std::span<const std::byte> bytes);

  /// Sets `into` to the bytes from `offset` on. Safe to call from several threads at once. False if
  /// they cannot be read, because they were not written or the disk fails.
  bool read(std::uint64_t offset, std::span<std::byte> into) const;

 private:
  explicit ScratchFile(Descriptor descriptor) : descriptor_(std::move(descriptor)) {}
  Descriptor descriptor_;
};

}  // namespace t4d::platform
