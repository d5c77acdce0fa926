#pragma once

#include <cstdint>
#include <optional>

#include "t4d/formats/t4d/chunk_file.h"

namespace t4d::formats {

/// Fails if there are more than `maxCells` cells, or usualCellLimit if that is not given.
Result<void> checkCellCount(const ChunkFile& file, std::uint64_t cells,
                            std::optional<std::uint64_t> maxCells);

}  // namespace t4d::formats
