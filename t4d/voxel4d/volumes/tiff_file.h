#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "t4d/model/error.h"
#include "t4d/voxel4d/sample_type.h"

struct tiff;  // of libtiff

namespace t4d::voxel4d {

/// What all pages of a series have in common.
struct TiffPage {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  SampleType type = SampleType::UInt8;

  std::uint64_t bytes() const { return std::uint64_t{width} * height * sizeOf(type); }
  friend bool operator==(const TiffPage&, const TiffPage&) = default;
};

/// A TIFF or BigTIFF, read by libtiff, whose messages become errors of this program.
class TiffFile {
 public:
  /// Fails unless the file is a regular file and a TIFF.
  static Result<TiffFile> open(const std::filesystem::path& path);

  const std::string& where() const { return where_; }
  /// Goes to the next page; false after the last.
  Result<bool> next();
  /// Goes to the page that is stored at this byte of the file.
  Result<void> goTo(std::uint64_t byte);
  /// Where this page is stored.
  std::uint64_t byte() const;

  /// Of this page. Fails for what is not one sample a pixel, of 8 to 64 bits.
  Result<TiffPage> layout() const;
  /// Whether it is a smaller copy of another page, or a mask of one.
  bool isAuxiliary() const;
  std::string description() const;
  /// Pixels a length unit along x and y; 0 if that is not said.
  double resolution(bool alongY) const;
  bool bigEndian() const;
  /// Where the samples are if they are not compressed and follow one another.
  std::optional<std::uint64_t> plainOffset() const;

  /// Unpacks this page; `into` has TiffPage::bytes.
  Result<void> read(const TiffPage& layout, std::span<std::byte> into) const;

 private:
  /// libtiff's first complaint since it was asked for the last time.
  struct Complaints {
    std::string first;
  };
  struct Closer {
    void operator()(tiff* file) const;
  };

  explicit TiffFile(std::string where) : where_(std::move(where)) {}
  Error failed(std::string what) const;
  std::string name() const;  // of the page, in messages
  Result<void> readTiles(const TiffPage& layout, std::span<std::byte> into) const;

  std::string where_;
  std::unique_ptr<Complaints> complaints_ = std::make_unique<Complaints>();
  std::unique_ptr<tiff, Closer> file_;
};

}  // namespace t4d::voxel4d
