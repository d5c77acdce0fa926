#include "formats/zip_entry.h"

#include <bit>
#include <limits>
#include <span>

#include <fmt/format.h>

#include "formats/zlib_block.h"

namespace t4d::formats {
namespace {

// Numbers are written as they are in memory.
static_assert(std::endian::native == std::endian::little);

constexpr std::uint32_t kLocalFile = 0x04034b50;
constexpr std::uint32_t kDirectoryFile = 0x02014b50;
constexpr std::uint32_t kDirectoryEnd = 0x06054b50;
constexpr std::size_t kLocalBytes = 30;
constexpr std::size_t kDirectoryBytes = 46;
constexpr std::size_t kEndBytes = 22;
constexpr std::size_t kAlignment = 64;
constexpr std::uint16_t kDirectoryVersion = 20;  // of the format, as for plain files
constexpr std::uint16_t kFirstOfJanuary1980 = 0x21;

void put16(std::string& bytes, std::uint64_t number) {
  bytes.append({static_cast<char>(number & 0xff), static_cast<char>(number >> 8U & 0xff)});
}

void put32(std::string& bytes, std::uint64_t number) {
  put16(bytes, number & 0xffff);
  put16(bytes, number >> 16U);
}

/// What both headers of a file share: version to crc and sizes, and the length of the name.
std::string sharedFields(std::uint32_t crc, std::uint64_t size, std::size_t nameBytes) {
  std::string bytes;
  put16(bytes, kDirectoryVersion);
  put16(bytes, 0);  // no flags
  put16(bytes, 0);  // stored
  put16(bytes, 0);  // midnight
  put16(bytes, kFirstOfJanuary1980);
  put32(bytes, crc);
  put32(bytes, size);
  put32(bytes, size);
  put16(bytes, nameBytes);
  return bytes;
}

}  // namespace

std::string ZipEntryWriter::header() const {
  std::string bytes;
  put32(bytes, kLocalFile);
  bytes += sharedFields(crc_, size_, name_.size());
  // A field that others skip fills up to the alignment; 4 bytes are its own header.
  const std::size_t before = kLocalBytes + name_.size() + 4;
  const std::size_t padding = (kAlignment - before % kAlignment) % kAlignment;
  put16(bytes, padding + 4);
  bytes += name_;
  constexpr std::uint16_t kUsdPadding = 0x1986;
  put16(bytes, kUsdPadding);
  put16(bytes, padding);
  return bytes + std::string(padding, '\0');
}

Result<void> ZipEntryWriter::begin() {
  const std::string bytes = header();
  return file_.write(bytes.data(), bytes.size());
}

Result<void> ZipEntryWriter::write(std::string_view bytes) {
  crc_ = zlibCrc32(bytes, crc_);
  size_ += bytes.size();
  return file_.write(bytes.data(), bytes.size());
}

Result<void> ZipEntryWriter::end() {
  const std::string head = header();
  const std::uint64_t directory = head.size() + size_;
  if (directory > std::numeric_limits<std::uint32_t>::max()) {
    return fail(ErrorCode::Unsupported, "has more than the 4 GiB that an archive can hold");
  }
  std::string bytes;
  put32(bytes, kDirectoryFile);
  put16(bytes, kDirectoryVersion);
  bytes += sharedFields(crc_, size_, name_.size());
  put16(bytes, 0);  // no extra field,
  put16(bytes, 0);  // comment,
  put16(bytes, 0);  // or other disks
  put16(bytes, 0);
  put32(bytes, 0);
  put32(bytes, 0);  // where the local header is
  bytes += name_;
  const std::size_t directoryBytes = bytes.size();
  put32(bytes, kDirectoryEnd);
  put32(bytes, 0);
  put16(bytes, 1);
  put16(bytes, 1);
  put32(bytes, directoryBytes);
  put32(bytes, directory);
  put16(bytes, 0);
  if (auto done = file_.write(bytes.data(), bytes.size()); !done) return done;
  return file_.rewrite(0, head.data(), head.size());
}

}  // namespace t4d::formats
