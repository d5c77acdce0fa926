#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "t4d/error.h"

namespace t4d::formats {

/// The bytes of an uncompressed grey-scale TIFF of 16-bit samples, with a page for each z, a row
/// for each y and a column for each x, which changes fastest in `samples`. `size` has the numbers
/// of columns, rows and pages, whose product is the number of samples. Fails if the file would have
/// 4 GiB or more, which TIFF cannot address.
Result<std::string> tiffOf(std::span<const std::uint16_t> samples,
                           const std::array<std::uint32_t, 3>& size);

}  // namespace t4d::formats
