#include "platform/descriptor.h"

#include <cerrno>

#include <unistd.h>

namespace t4d::platform {

bool Descriptor::close() noexcept {
  const int number = std::exchange(number_, -1);
  return number < 0 || ::close(number) == 0;
}

std::ptrdiff_t Descriptor::read(std::span<std::byte> into) const {
  ssize_t got = 0;
  do {
    got = ::read(number_, into.data(), into.size());
  } while (got < 0 && errno == EINTR);
  return got;
}

std::ptrdiff_t Descriptor::readAt(std::uint64_t offset, std::span<std::byte> into) const {
  std::size_t have = 0;
  while (have < into.size()) {
    const ssize_t got =
        ::pread(number_, into.data() + have, into.size() - have, static_cast<off_t>(offset + have));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return -1;
    if (got == 0) break;
    have += static_cast<std::size_t>(got);
  }
  return static_cast<std::ptrdiff_t>(have);
}

bool Descriptor::write(std::string_view bytes) const {
  while (!bytes.empty()) {
    const ssize_t written = ::write(number_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

bool Descriptor::writeAt(std::uint64_t offset, std::string_view bytes) const {
  while (!bytes.empty()) {
    const ssize_t written =
        ::pwrite(number_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    offset += static_cast<std::uint64_t>(written);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

}  // namespace t4d::platform
