#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "platform/scratch_file.h"

namespace t4d::voxel4d {

/// Numbers of a large frame that weaving needs a few times only, in a temporary file instead of in
/// memory.
class FrameFile {
 public:
  /// An empty file.
  static Result<std::unique_ptr<FrameFile>> create();

  Result<void> append(std::span<const std::byte> bytes) { return file_.append(bytes); }

  /// Sets `into` to the bytes from `offset` on, or to zero if they cannot be read; for several
  /// threads at a time.
  void read(std::uint64_t offset, std::span<std::byte> into) const;

  /// Fails if something that was asked for could not be read.
  Result<void> checkRead() const;

 private:
  explicit FrameFile(platform::ScratchFile file) : file_(std::move(file)) {}

  platform::ScratchFile file_;
  mutable std::atomic<bool> whole_ = true;
};

}  // namespace t4d::voxel4d
