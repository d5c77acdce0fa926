#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "t4d/error.h"

/// Errors of voxel sizes, for voxels of any kind.
namespace t4d::model {

/// Voxel sizes, in length units. Distances of a few voxels are float32.
inline constexpr double kSmallestVoxelSize = 1e-30;
inline constexpr double kLargestVoxelSize = 1e30;

/// Fails (InvalidInput) for a size out of this range, and for one that is not finite.
Result<void> checkVoxelSize(double size, Remedy remedy = Remedy::VoxelSize);

/// The memory for voxels of a size.
struct VoxelMemory {
  double voxelSize;
  double bytes;  ///< estimated
  double limit;  ///< in bytes, less than that
};

/// The error (Unsupported) for more memory than the limit. `need` says what needs it, as "the stock
/// needs"; `fitting`, what fits.
Error tooMuchMemory(const VoxelMemory& memory, std::string_view need, std::string_view fitting,
                    Remedy remedy = Remedy::VoxelSize);

/// The error (Unsupported, VoxelSize) for more voxels along an axis than there can be; `also` is
/// what else limits them.
Error tooManyVoxels(double size, double count, std::uint64_t most, std::string_view also = {});

/// An estimate of memory as sizeText has it; of any size.
std::string memoryText(double bytes);

}  // namespace t4d::model
