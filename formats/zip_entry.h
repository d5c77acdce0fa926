#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "formats/output_file.h"

/// Zip archives of files that are stored, as USD packages (.usdz) are.
namespace t4d::formats {

/// Writes an archive of one file, whose bytes begin at a multiple of 64 and come piece by piece.
class ZipEntryWriter {
 public:
  ZipEntryWriter(OutputFile& file, std::string name) : file_(file), name_(std::move(name)) {}

  Result<void> begin();
  Result<void> write(std::string_view bytes);
  /// Fails for more than 4 GiB, and where the target is a pipe: sizes are at the beginning.
  Result<void> end();

 private:
  std::string header() const;

  OutputFile& file_;
  std::string name_;
  std::uint64_t size_ = 0;
  std::uint32_t crc_ = 0;
};

}  // namespace t4d::formats
