#pragma once

#include <cstdint>

namespace t4d::model {

/// In place of the number of a vertex, triangle or cell, or another number given in memory: none.
inline constexpr std::uint32_t kNoIndex = ~std::uint32_t{0};

}  // namespace t4d::model
