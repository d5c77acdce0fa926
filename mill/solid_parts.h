#pragma once

#include <cstdint>

#include "mill/stock_field.h"

namespace t4d::mill {

/// The number of parts that the solid of a field consists of. Points inside are joined if they are
/// corners of one voxel, as 4D marching cubes join them.
std::uint64_t countParts(const StockField& field);

}  // namespace t4d::mill
