#pragma once

#include <string_view>

namespace t4d::voxel4d {

/// Whether `a` comes before `b` if runs of digits are compared as numbers: frame2 before frame10.
bool naturallyLess(std::string_view a, std::string_view b);

}  // namespace t4d::voxel4d
