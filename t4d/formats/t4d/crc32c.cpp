#include "t4d/formats/t4d/crc32c.h"

#include <algorithm>

#include <isa-l/crc.h>

#include "t4d/system/upper_halves.h"

namespace t4d::formats {
std::uint32_t crc32c(const void* data, std::size_t size, std::uint32_t before) {
  // The library takes the length as an int, and a pointer to non-const.
  constexpr std::size_t kPiece = std::size_t{1} << 30;
  auto* from = static_cast<unsigned char*>(const_cast<void*>(data));
  std::uint32_t crc = ~before;
  while (size > 0) {
    const std::size_t now = std::min(size, kPiece);
    crc = crc32_iscsi(from, static_cast<int>(now), crc);
    from += now;
    size -= now;
  }
  system::clearUpperHalves();
  return ~crc;
}

}  // namespace t4d::formats
