#pragma once

#include <cstddef>
#include <cstdint>

namespace t4d::formats {

/// CRC-32C (Castagnoli), as in iSCSI: reflected polynomial 0x82F63B78, initial value and final XOR
/// all ones. The check value for "123456789" is 0xE3069283.
std::uint32_t crc32c(const void* data, std::size_t size);

}  // namespace t4d::formats
