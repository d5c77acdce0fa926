#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>

#include "t4d/error.h"

namespace t4d::formats {

/// A whole file in memory.
struct InputFile {
  std::filesystem::path path = {};
  std::string bytes = {};

  /// The two forms of `Error::where`: `path:LINE` (from 1) and `path: byte N` (from 0).
  Place atLine(std::uint64_t line) const;
  Place atByte(std::uint64_t offset) const;
};

/// Reads a file that exists, is a regular file and is not empty; everything else is an error.
Result<InputFile> readInputFile(const std::filesystem::path& path);

/// The number of type T at `from`, in the given byte order.
template <class T>
T loadNumber(const char* from, std::endian order = std::endian::little) {
  char bytes[sizeof(T)];
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    bytes[i] = from[order == std::endian::native ? i : sizeof(T) - 1 - i];
  }
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

}  // namespace t4d::formats
