#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "t4d/error.h"

namespace t4d::formats {

/// Fails if the file `name`, of `bytes` bytes, has more than `maxCells` cells, or usualCellLimit if
/// that is not given.
Result<void> checkCellCount(const std::string& name, std::uint64_t bytes, std::uint64_t cells,
                            std::optional<std::uint64_t> maxCells);

}  // namespace t4d::formats
