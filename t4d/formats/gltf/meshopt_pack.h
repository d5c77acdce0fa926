#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace t4d::formats {

/// The bytes as EXT_meshopt_compression has them: elements of `elementBytes`, or the indices of
/// triangles (2 or 4 bytes each). Nothing for elements that it cannot hold, whose size is no
/// multiple of four or more than 256, and in a build without meshoptimizer.
std::optional<std::vector<unsigned char>> meshoptPacked(std::span<const unsigned char> bytes,
                                                        std::size_t elementBytes, bool isTriangles);

}  // namespace t4d::formats
