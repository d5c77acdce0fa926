#include "formats/tiff_writer.h"

#include <limits>
#include <type_traits>

#include <fmt/format.h>

namespace t4d::formats {
namespace {

/// Appends a number in little-endian order.
template <class Number>
void append(std::string& bytes, Number number) {
  for (std::size_t i = 0; i < sizeof(number); ++i) {
    bytes += static_cast<char>(static_cast<std::uint64_t>(number) >> (8 * i) & 0xff);
  }
}

/// A field of a page with one number. Short numbers fill the first two of its four bytes.
template <class Number>
void appendField(std::string& bytes, std::uint16_t tag, Number number) {
  constexpr std::uint16_t kType = std::is_same_v<Number, std::uint16_t> ? 3 : 4;
  append(bytes, tag);
  append(bytes, kType);
  append(bytes, std::uint32_t{1});
  append(bytes, std::uint32_t{number});
}

}  // namespace

Result<std::string> tiffOf(std::span<const std::uint16_t> samples,
                           const std::array<std::uint32_t, 3>& size) {
  constexpr std::uint16_t kFields = 10;
  constexpr std::uint64_t kHeader = 8;
  constexpr std::uint64_t kDirectory = 2 + 12 * kFields + 4;
  const auto& [columns, rows, pages] = size;
  const std::uint64_t page = 2 * std::uint64_t{columns} * rows;
  const std::uint64_t total = kHeader + pages * (page + kDirectory);
  if (total > std::numeric_limits<std::uint32_t>::max()) {
    return fail(ErrorCode::Unsupported,
                fmt::format("an image of {} x {} x {} samples has {} bytes; TIFF has less than 4 "
                            "GiB",
                            columns, rows, pages, total));
  }
  std::string bytes;
  bytes.reserve(total);
  bytes += "II";
  append(bytes, std::uint16_t{42});
  append(bytes, static_cast<std::uint32_t>(kHeader + pages * page));
  for (const std::uint16_t sample : samples) append(bytes, sample);
  for (std::uint64_t i = 0; i < pages; ++i) {
    append(bytes, kFields);
    appendField(bytes, 256, columns);
    appendField(bytes, 257, rows);
    appendField(bytes, 258, std::uint16_t{16});  // bits per sample
    appendField(bytes, 259, std::uint16_t{1});   // not compressed
    appendField(bytes, 262, std::uint16_t{1});   // 0 is black
    appendField(bytes, 273, static_cast<std::uint32_t>(kHeader + i * page));
    appendField(bytes, 277, std::uint16_t{1});  // samples per pixel
    appendField(bytes, 278, rows);              // in one strip
    appendField(bytes, 279, static_cast<std::uint32_t>(page));
    appendField(bytes, 339, std::uint16_t{1});  // unsigned
    const bool last = i + 1 == pages;
    append(bytes,
           static_cast<std::uint32_t>(last ? 0 : kHeader + pages * page + (i + 1) * kDirectory));
  }
  return bytes;
}

}  // namespace t4d::formats
