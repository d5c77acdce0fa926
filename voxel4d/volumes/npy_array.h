#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "t4d/error.h"
#include "voxel4d/sample_type.h"

namespace t4d::voxel4d {

/// The data in the header of a .npy file about the samples that follow it.
struct NpyArray {
  SampleType type = SampleType::Float32;
  std::endian order = std::endian::little;
  bool fortran = false;  ///< the first axis varies fastest, not the last
  std::vector<std::uint64_t> shape = {};

  bool operator==(const NpyArray&) const = default;
};

/// Reads the header of a .npy file, of versions 1 to 3 (numpy.lib.format). `read` sets bytes to
/// those that follow and returns how many there are.
Result<NpyArray> readNpyArray(const std::function<Result<std::size_t>(std::span<std::byte>)>& read,
                              const Place& where);

}  // namespace t4d::voxel4d
