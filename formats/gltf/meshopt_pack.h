#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "t4d/error.h"

namespace t4d::formats {

/// The bytes as EXT_meshopt_compression has them: elements of `elementBytes`, or the indices of
/// triangles (2 or 4 bytes each). Nothing for elements that it cannot hold, whose size is no
/// multiple of four or more than 256, and in a build without meshoptimizer.
std::optional<std::vector<unsigned char>> meshoptPacked(std::span<const unsigned char> bytes,
                                                        std::size_t elementBytes, bool isTriangles);

/// The contents of a compressed buffer view, in the words of the extension.
struct MeshoptView {
  std::size_t count = 0;
  std::size_t byteStride = 0;
  std::string_view mode;    ///< ATTRIBUTES, TRIANGLES or INDICES
  std::string_view filter;  ///< NONE, OCTAHEDRAL, QUATERNION or EXPONENTIAL
};

/// The reverse, for every mode and filter: `count` elements of `byteStride` bytes. Fails, naming no
/// place, on what the extension does not allow, on damaged bytes, on versions and filters that the
/// linked meshoptimizer does not know, and in a build without it.
Result<std::vector<unsigned char>> meshoptUnpacked(std::span<const unsigned char> packed,
                                                   const MeshoptView& view);

}  // namespace t4d::formats
