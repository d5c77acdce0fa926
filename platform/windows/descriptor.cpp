#include "platform/descriptor.h"

#include <algorithm>
#include <cerrno>

#include <io.h>

#include "platform/windows/system_file.h"

namespace t4d::platform {
namespace {

/// The system counts the bytes of a call in 32 bits.
constexpr std::size_t kMostBytes = std::size_t{1} << 30;

DWORD bytesOfCall(std::size_t bytes) { return static_cast<DWORD>(std::min(bytes, kMostBytes)); }

/// A place in a file. The calls that take it move the place of `read`, too, but not between its
/// looking and its reading, since nobody uses both.
OVERLAPPED placeAt(std::uint64_t offset) {
  OVERLAPPED place{};
  place.Offset = static_cast<DWORD>(offset);
  place.OffsetHigh = static_cast<DWORD>(offset >> 32);
  return place;
}

}  // namespace

bool Descriptor::close() noexcept {
  const int number = std::exchange(number_, -1);
  return number < 0 || ::_close(number) == 0;
}

std::ptrdiff_t Descriptor::read(std::span<std::byte> into) const {
  return ::_read(number_, into.data(), bytesOfCall(into.size()));
}

std::ptrdiff_t Descriptor::readAt(std::uint64_t offset, std::span<std::byte> into) const {
  std::size_t have = 0;
  while (have < into.size()) {
    OVERLAPPED place = placeAt(offset + have);
    DWORD got = 0;
    if (ReadFile(handleOf(*this), into.data() + have, bytesOfCall(into.size() - have), &got,
                 &place) == 0) {
      if (GetLastError() == ERROR_HANDLE_EOF) break;
      return setErrno();
    }
    if (got == 0) break;
    have += got;
  }
  return static_cast<std::ptrdiff_t>(have);
}

bool Descriptor::write(std::string_view bytes) const {
  while (!bytes.empty()) {
    const int written = ::_write(number_, bytes.data(), bytesOfCall(bytes.size()));
    if (written < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

bool Descriptor::writeAt(std::uint64_t offset, std::string_view bytes) const {
  // Elsewhere this does not move the place of `write`.
  const auto before = ::_lseeki64(number_, 0, SEEK_CUR);
  while (!bytes.empty()) {
    OVERLAPPED place = placeAt(offset);
    DWORD written = 0;
    if (WriteFile(handleOf(*this), bytes.data(), bytesOfCall(bytes.size()), &written, &place) ==
        0) {
      setErrno();
      return false;
    }
    offset += written;
    bytes.remove_prefix(written);
  }
  return ::_lseeki64(number_, before, SEEK_SET) == before;
}

}  // namespace t4d::platform
