#pragma once

#include <filesystem>
#include <span>

#include "t4d/error.h"

namespace t4d::formats {

/// Fails if a number is missing, or comes twice, in a numbered series: files such as frame_2.obj
/// and frame_3.obj, whose names are alike but for their last digits and whose numbers do not
/// decrease. Files in any other order are not a series.
Result<void> checkNumbers(std::span<const std::filesystem::path> files);

}  // namespace t4d::formats
