#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "t4d/model/error.h"

namespace t4d::formats {

/// Puts the files of a numbered series, frame_2.obj and frame_10.obj, in the order of their
/// numbers: the last digits of their names. Files whose names are not alike but for a number stay
/// in the order given. Fails where a number is missing or comes twice.
Result<std::vector<std::filesystem::path>> inNumberOrder(
    std::span<const std::filesystem::path> files);

}  // namespace t4d::formats
