#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include <isa-l/crc.h>

#include "platform/upper_halves.h"

namespace t4d::platform {

/// CRC-32C (Castagnoli), as in iSCSI: reflected polynomial 0x82F63B78, initial value and final XOR
/// all ones. The check value for "123456789" is 0xE3069283. `before` is the checksum of the bytes
/// before these, if any. Callers must link ISA-L.
inline std::uint32_t crc32c(const void* data, std::size_t size, std::uint32_t before = 0) {
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
  clearUpperHalves();
  return ~crc;
}

}  // namespace t4d::platform
