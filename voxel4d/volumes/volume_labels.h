#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "t4d/frames.h"

namespace t4d::voxel4d {

/// The maximum number of labels of a volume: an image with more different values is not one of
/// labels.
inline constexpr std::size_t kMostLabels = 1000;

/// The labels of volumes, in increasing order: all values of their samples except 0, the
/// background. Reads every frame, of a region only the samples in it. Fails as openVolumeFrames
/// does, for bools, samples that are not whole numbers, no label, and more than kMostLabels.
Result<std::vector<std::int64_t>> labelsOf(std::span<const std::filesystem::path> files,
                                           const VolumeOptions& options);

}  // namespace t4d::voxel4d
