#include "t4d/voxel4d/volumes/tiff_file.h"

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <vector>

#include <fmt/format.h>
#include <tiffio.h>

#include "t4d/system/regular_file.h"
#include "t4d/voxel4d/volumes/header_text.h"

namespace t4d::voxel4d {
namespace {

/// More than any buffer that is needed: a strip or tile, or a table of them.
constexpr tmsize_t kMostAtOnce = tmsize_t{1} << 31U;

}  // namespace

void TiffFile::Closer::operator()(tiff* file) const { TIFFClose(file); }

Result<TiffFile> TiffFile::open(const std::filesystem::path& path) {
  if (const auto size = system::sizeOfRegularFile(path); !size) return size.error();
  TiffFile opened(path.string());
  const std::unique_ptr<TIFFOpenOptions, decltype(&TIFFOpenOptionsFree)> options(
      TIFFOpenOptionsAlloc(), &TIFFOpenOptionsFree);
  TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), kMostAtOnce);
  const auto keep = [](tiff*, void* to, const char*, const char* format, va_list values) {
    std::string& first = static_cast<Complaints*>(to)->first;
    if (first.empty()) {
      std::array<char, 200> text{};
      (void)std::vsnprintf(text.data(), text.size(), format, values);
      first = text.data();
    }
    return 1;
  };
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), keep, opened.complaints_.get());
  TIFFOpenOptionsSetWarningHandlerExtR(
      options.get(), [](tiff*, void*, const char*, const char*, va_list) { return 1; }, nullptr);
  // Without mapping it, so that a file that is cut while it is read is an error.
  opened.file_.reset(TIFFOpenExt(path.c_str(), "rm", options.get()));
  if (!opened.file_) return opened.failed("is no TIFF that can be read");
  return opened;
}

Error TiffFile::failed(std::string message) const {
  if (!complaints_->first.empty()) {
    std::string said = complaints_->first;
    for (char& c : said) {
      if (static_cast<unsigned char>(c) < 32 || static_cast<unsigned char>(c) > 126) c = '?';
    }
    message += fmt::format(" (libtiff: {})", said);
    complaints_->first.clear();
  }
  return invalid(std::move(message), where_);
}

Result<bool> TiffFile::next() {
  complaints_->first.clear();
  if (TIFFReadDirectory(file_.get()) != 0) return true;
  // Also after the last page, without a complaint.
  if (!complaints_->first.empty()) return failed("a page is damaged");
  return false;
}

Result<void> TiffFile::goTo(std::uint64_t byte) {
  complaints_->first.clear();
  if (byte == this->byte()) return {};
  if (TIFFSetSubDirectory(file_.get(), byte) != 0) return {};
  return failed(fmt::format("the page at byte {} is damaged", byte));
}

std::uint64_t TiffFile::byte() const { return TIFFCurrentDirOffset(file_.get()); }

std::string TiffFile::name() const { return fmt::format("the page at byte {}", byte()); }

Result<TiffPage> TiffFile::layout() const {
  TiffPage found;
  std::uint16_t samples = 1;
  std::uint16_t bits = 1;
  std::uint16_t format = SAMPLEFORMAT_UINT;
  TIFFGetField(file_.get(), TIFFTAG_IMAGEWIDTH, &found.width);
  TIFFGetField(file_.get(), TIFFTAG_IMAGELENGTH, &found.height);
  TIFFGetFieldDefaulted(file_.get(), TIFFTAG_SAMPLESPERPIXEL, &samples);
  TIFFGetFieldDefaulted(file_.get(), TIFFTAG_BITSPERSAMPLE, &bits);
  TIFFGetFieldDefaulted(file_.get(), TIFFTAG_SAMPLEFORMAT, &format);
  const std::string where = name();
  if (found.width == 0 || found.height == 0) {
    return invalid(fmt::format("{} has {} x {} pixels", where, found.width, found.height), where_);
  }
  if (samples != 1) {
    return invalid(fmt::format("{} has {} samples a pixel, expected 1: split its colours into "
                               "channels, or make it grey",
                               where, samples),
                   where_);
  }
  struct Kind {
    std::uint16_t format, bits;
    SampleType type;
  };
  constexpr std::array kKinds = {Kind{SAMPLEFORMAT_UINT, 8, SampleType::UInt8},
                                 Kind{SAMPLEFORMAT_UINT, 16, SampleType::UInt16},
                                 Kind{SAMPLEFORMAT_UINT, 32, SampleType::UInt32},
                                 Kind{SAMPLEFORMAT_UINT, 64, SampleType::UInt64},
                                 Kind{SAMPLEFORMAT_INT, 8, SampleType::Int8},
                                 Kind{SAMPLEFORMAT_INT, 16, SampleType::Int16},
                                 Kind{SAMPLEFORMAT_INT, 32, SampleType::Int32},
                                 Kind{SAMPLEFORMAT_INT, 64, SampleType::Int64},
                                 Kind{SAMPLEFORMAT_IEEEFP, 32, SampleType::Float32},
                                 Kind{SAMPLEFORMAT_IEEEFP, 64, SampleType::Float64}};
  const auto kind = std::ranges::find_if(
      kKinds, [&](const Kind& one) { return one.format == format && one.bits == bits; });
  if (kind == kKinds.end()) {
    return invalid(fmt::format("{} has samples of {} bits and format {}; integers of 8 to 64 bits "
                               "and floats of 32 and 64 can be used",
                               where, bits, format),
                   where_);
  }
  found.type = kind->type;
  return found;
}

bool TiffFile::isAuxiliary() const {
  std::uint32_t kind = 0;
  TIFFGetField(file_.get(), TIFFTAG_SUBFILETYPE, &kind);
  return (kind & (FILETYPE_REDUCEDIMAGE | FILETYPE_MASK)) != 0;
}

std::string TiffFile::description() const {
  const char* text = nullptr;
  if (TIFFGetField(file_.get(), TIFFTAG_IMAGEDESCRIPTION, &text) == 0 || text == nullptr) return {};
  return text;
}

double TiffFile::resolution(bool alongY) const {
  float found = 0;
  TIFFGetField(file_.get(), alongY ? TIFFTAG_YRESOLUTION : TIFFTAG_XRESOLUTION, &found);
  return static_cast<double>(found);
}

bool TiffFile::bigEndian() const { return TIFFIsBigEndian(file_.get()) != 0; }

std::optional<std::uint64_t> TiffFile::plainOffset() const {
  std::uint16_t compression = COMPRESSION_NONE;
  TIFFGetFieldDefaulted(file_.get(), TIFFTAG_COMPRESSION, &compression);
  if (compression != COMPRESSION_NONE || TIFFIsTiled(file_.get()) != 0) return std::nullopt;
  return TIFFGetStrileOffset(file_.get(), 0);
}

Result<void> TiffFile::read(const TiffPage& layout, std::span<std::byte> into) const {
  complaints_->first.clear();
  const std::string damaged = name() + " is damaged";
  if (TIFFIsTiled(file_.get()) != 0) return readTiles(layout, into);
  const std::uint32_t strips = TIFFNumberOfStrips(file_.get());
  std::uint32_t rows = layout.height;
  TIFFGetFieldDefaulted(file_.get(), TIFFTAG_ROWSPERSTRIP, &rows);
  rows = std::min(rows, layout.height);
  const std::uint64_t rowBytes = std::uint64_t{layout.width} * sizeOf(layout.type);
  std::uint64_t at = 0;
  for (std::uint32_t strip = 0; strip < strips && at < into.size(); ++strip) {
    const std::uint64_t size = std::min<std::uint64_t>(rows * rowBytes, into.size() - at);
    const tmsize_t got =
        TIFFReadEncodedStrip(file_.get(), strip, into.data() + at, static_cast<tmsize_t>(size));
    if (got != static_cast<tmsize_t>(size)) return failed(damaged);
    at += size;
  }
  if (at != into.size()) return failed(damaged);
  return {};
}

Result<void> TiffFile::readTiles(const TiffPage& layout, std::span<std::byte> into) const {
  const std::string damaged = name() + " is damaged";
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  TIFFGetField(file_.get(), TIFFTAG_TILEWIDTH, &width);
  TIFFGetField(file_.get(), TIFFTAG_TILELENGTH, &height);
  const std::size_t size = sizeOf(layout.type);
  // No tile is much larger than a page.
  const std::uint64_t tileBytes = std::uint64_t{width} * height * size;
  constexpr std::uint64_t kMostOfPage = 1024;
  if (width == 0 || height == 0 || tileBytes / kMostOfPage > layout.bytes() + kMostOfPage ||
      TIFFTileSize64(file_.get()) != tileBytes) {
    return failed(damaged);
  }
  std::vector<std::byte> tile(tileBytes);
  for (std::uint32_t y = 0; y < layout.height; y += std::min(height, layout.height - y)) {
    for (std::uint32_t x = 0; x < layout.width; x += std::min(width, layout.width - x)) {
      const std::uint32_t number = TIFFComputeTile(file_.get(), x, y, 0, 0);
      const tmsize_t got =
          TIFFReadEncodedTile(file_.get(), number, tile.data(), static_cast<tmsize_t>(tile.size()));
      if (got != static_cast<tmsize_t>(tile.size())) return failed(damaged);
      const std::size_t columns = std::min(width, layout.width - x) * size;
      for (std::uint32_t row = 0; row < std::min(height, layout.height - y); ++row) {
        const std::byte* from = tile.data() + std::size_t{row} * width * size;
        std::byte* to = into.data() + (std::size_t{y + row} * layout.width + x) * size;
        std::copy(from, from + columns, to);
      }
    }
  }
  return {};
}

}  // namespace t4d::voxel4d
