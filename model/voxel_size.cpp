#include "model/voxel_size.h"

#include <fmt/format.h>

#include "model/amount_text.h"

namespace t4d::model {

Result<void> checkVoxelSize(double size, Remedy remedy) {
  if (size >= kSmallestVoxelSize && size <= kLargestVoxelSize) return {};
  return invalid(fmt::format("voxels of {} are requested; {} to {} are possible", size,
                             kSmallestVoxelSize, kLargestVoxelSize),
                 {}, remedy);
}

Error tooMuchMemory(const VoxelMemory& memory, std::string_view need, std::string_view fitting,
                    Remedy remedy) {
  return fail(ErrorCode::Unsupported,
              fmt::format("with a voxel size of {} {} about {} of memory, more than the limit of "
                          "{}; {}",
                          memory.voxelSize, need, memoryText(memory.bytes),
                          memoryText(memory.limit), fitting),
              {}, remedy);
}

Error tooManyVoxels(double size, double count, std::uint64_t most, std::string_view also) {
  return fail(
      ErrorCode::Unsupported,
      fmt::format("with a voxel size of {} there are {:.3g} voxels along an axis; at most {} "
                  "are possible{}",
                  size, count, most, also),
      {}, Remedy::VoxelSize);
}

std::string memoryText(double bytes) {
  constexpr double kMostAsCount = 1e15;
  if (bytes < kMostAsCount) return sizeText(static_cast<std::uint64_t>(bytes));
  return fmt::format("{:.3g} GB", bytes / 1e9);
}

}  // namespace t4d::model
