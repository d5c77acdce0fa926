#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "t4d/error.h"
#include "voxel4d/volumes/volume.h"

namespace t4d::voxel4d {

/// Reads the bytes of samples one after another, unpacked.
class SampleReader {
 public:
  virtual ~SampleReader() = default;

  /// Fills `into`; fails where the data end.
  virtual Result<void> read(std::span<std::byte> into) = 0;
  /// Skips this many bytes.
  virtual Result<void> skip(std::uint64_t bytes) = 0;
  /// Fails if there is more, unless there may be, and if the end is damaged.
  virtual Result<void> finish(bool mayHaveMore) = 0;
};

/// `bytes` is what is wanted in all, of samples of `type`: it is judged by the size of the file
/// before anything is read. Texts are converted to samples in the order of this machine.
Result<std::unique_ptr<SampleReader>> openSamples(const SampleData& data, SampleType type,
                                                  std::uint64_t bytes);

/// The bytes to which the gzip data from `offset` on unpack. Fails if they are damaged.
Result<std::uint64_t> unpackedBytes(const std::filesystem::path& path, std::uint64_t offset);

}  // namespace t4d::voxel4d
