#include "t4d/formats/zip_entry.h"

#include <bit>
#include <limits>
#include <span>

#include <fmt/format.h>
#include <isa-l/crc.h>

#include "t4d/system/upper_halves.h"

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
  crc_ = crc32_gzip_refl(crc_, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  system::clearUpperHalves();
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

Result<ZipEntry> firstZipEntry(const InputFile& file) {
  const std::string_view bytes = file.bytes;
  const auto number16 = [&](std::size_t at) { return loadNumber<std::uint16_t>(&bytes[at]); };
  const auto number32 = [&](std::size_t at) { return loadNumber<std::uint32_t>(&bytes[at]); };
  const auto damaged = [&](const char* what, std::size_t at) {
    return invalid(what, file.atByte(at));
  };
  // The last record of an archive, behind which there may be a comment.
  constexpr std::string_view kEndMark("PK\x05\x06", 4);
  const std::size_t end = bytes.rfind(kEndMark);
  if (end == bytes.npos || bytes.size() - end < kEndBytes) {
    return damaged("the file ends without the directory of an archive", bytes.size());
  }
  const std::size_t entry = number32(end + 16);
  if (entry > end || end - entry < kDirectoryBytes || number32(entry) != kDirectoryFile) {
    return damaged("does not refer to the directory of an archive", end + 16);
  }
  const std::uint16_t flags = number16(entry + 8);
  const std::uint16_t method = number16(entry + 10);
  const std::size_t size = number32(entry + 24);
  const std::size_t nameBytes = number16(entry + 28);
  const std::size_t local = number32(entry + 42);
  if (nameBytes > end - entry - kDirectoryBytes) return damaged("a name is cut off", entry);
  if ((flags & 1U) != 0 || method != 0) {
    return fail(ErrorCode::Unsupported,
                "a file in a USD package is stored as it is; this one is compressed or encrypted",
                file.atByte(entry));
  }
  if (local > entry || entry - local < kLocalBytes || number32(local) != kLocalFile) {
    return damaged("does not refer to a file of the archive", entry + 42);
  }
  const std::size_t begin = local + kLocalBytes + number16(local + 26) + number16(local + 28);
  if (begin > entry || size > entry - begin) {
    return damaged("a file of the archive is cut off", local);
  }
  return ZipEntry{bytes.substr(entry + kDirectoryBytes, nameBytes), bytes.substr(begin, size)};
}

}  // namespace t4d::formats
