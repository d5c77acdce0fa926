#pragma once

#include <limits>
#include <vector>

#include "t4d/voxel4d/volumes/sample_reader.h"

namespace t4d::voxel4d {

/// Samples in planes that can be read as a whole only; those that are passed over are not read.
class PlaneReader : public SampleReader {
 public:
  explicit PlaneReader(std::uint64_t planeBytes) : planeBytes_(planeBytes) {}

  Result<void> read(std::span<std::byte> into) final;
  Result<void> skip(std::uint64_t bytes) final {
    at_ += bytes;
    return {};
  }
  Result<void> finish(bool /*mayHaveMore*/) final { return {}; }

 protected:
  virtual Result<void> readPlane(std::uint64_t number, std::span<std::byte> into) = 0;

 private:
  std::uint64_t planeBytes_;
  std::uint64_t at_ = 0;
  std::vector<std::byte> plane_;  // the last of which a part was read
  std::uint64_t number_ = std::numeric_limits<std::uint64_t>::max();
};

}  // namespace t4d::voxel4d
