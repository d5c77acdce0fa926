#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "t4d/system/scratch_file.h"
#include "t4d/voxel4d/frame.h"

namespace t4d::voxel4d {

/// What weaving needs of a large frame a few times only, the last of them when the next frame has
/// been read, in a temporary file: where along their edges its crossings are, and the values of its
/// blocks.
class FrameFile {
 public:
  /// Room for the values of a block.
  using Buffer = std::array<double, 512>;

  /// An empty file. Null for frames whose values stay in memory, as they have fewer bytes than
  /// `largeFrame` or are of several types.
  static Result<std::unique_ptr<FrameFile>> create(const Frame& frame, std::size_t largeFrame);

  /// Adds the fractions of the next crossings, in the order of their numbers.
  Result<void> addFractions(std::span<const double> fractions);

  /// Moves the values of the frame here, after all fractions, and lets go of their owner. Of its
  /// BlockValues only `sign` and `iso` are left.
  Result<void> takeValues(Frame& frame);

  /// Sets `into` to the fractions of the crossings from number `first` on.
  void fractions(std::uint32_t first, std::span<double> into) const;

  /// The values of the block with this number in its frame, as long as `buffer` is left alone;
  /// `left` is what the frame has of them.
  BlockValues values(std::uint32_t block, BlockValues left, Buffer& buffer) const;

  /// Whether all that was asked for could be read; what could not is zero.
  bool isWhole() const { return whole_; }

 private:
  FrameFile(system::ScratchFile file, std::size_t valueSize)
      : file_(std::move(file)), valueSize_(valueSize) {}
  void read(std::uint64_t offset, std::span<std::byte> into) const;

  system::ScratchFile file_;
  std::size_t valueSize_;
  std::uint64_t bytesOfFractions_ = 0;
  mutable std::atomic<bool> whole_ = true;
};

}  // namespace t4d::voxel4d
