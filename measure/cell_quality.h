#pragma once

#include <array>

#include "t4d/check.h"

namespace t4d::measure {

/// As many tetrahedra as are measured at once.
inline constexpr std::size_t kCellsTogether = 4;
using CellsTogether = std::array<std::array<model::Point4, 4>, kCellsTogether>;

/// What qualityOf says of each, to the last bit.
std::array<CellQuality, kCellsTogether> qualitiesOf(const CellsTogether& cells, double timeScale);

}  // namespace t4d::measure
