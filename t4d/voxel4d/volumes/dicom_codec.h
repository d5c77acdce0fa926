#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "t4d/model/error.h"

namespace t4d::voxel4d {

/// A compressed image and what it is expected to hold.
struct DicomPacked {
  std::string_view bytes;
  std::string_view syntax;  ///< the UID of the transfer syntax
  std::uint32_t columns = 0;
  std::uint32_t rows = 0;
  std::uint32_t bits = 0;
  std::uint32_t stored = 0;
  bool isSigned = false;
};

/// Unpacks an image by GDCM, in a process of its own: samples in the order of this machine, one row
/// after another. Fails for what is damaged, what GDCM cannot unpack, and in a build without it.
Result<std::string> unpackDicomImage(const DicomPacked& image);

}  // namespace t4d::voxel4d
