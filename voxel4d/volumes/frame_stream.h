#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "platform/open_file.h"
#include "platform/scratch_file.h"
#include "t4d/error.h"

namespace t4d::voxel4d {

struct Volume;

/// The bytes of standard input, in order. Not for several threads at once.
class InputBytes {
 public:
  /// `keep`: what is read is copied to a temporary file, so that it can be read again.
  explicit InputBytes(bool keep) : keep_(keep) {}

  /// Goes back to the first byte. Fails if there is no copy of what was read.
  Result<void> begin();

  /// Sets `into` to the bytes that follow and returns how many there are: fewer only at the end.
  Result<std::size_t> read(std::span<std::byte> into);

 private:
  /// Takes bytes of standard input that were not read so far; none at its end.
  Result<std::size_t> take(std::span<std::byte> into);

  bool keep_;
  std::uint64_t at_ = 0;     // of the next byte that is read
  std::uint64_t taken_ = 0;  // bytes of standard input
  std::optional<platform::OpenFile> input_;
  std::optional<platform::ScratchFile> copy_;
  std::vector<std::byte> window_;  // some of the bytes, for small reads
  std::uint64_t windowBegin_ = 0;
};

/// Frames that another program writes (docs/frame-stream.md): a line of JSON, then a .npy for each
/// frame. `input` is read as frames are requested, and may end at the last.
Result<Volume> readFrameStream(std::shared_ptr<InputBytes> input);

}  // namespace t4d::voxel4d
