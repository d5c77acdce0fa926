#pragma once

#include <cstddef>
#include <cstdint>

namespace t4d::platform {

/// CRC-32C (Castagnoli), as in iSCSI: reflected polynomial 0x82F63B78, initial value and final XOR
/// all ones. The check value for "123456789" is 0xE3069283. `before` is the checksum of the bytes
/// before these, if any.
std::uint32_t crc32c(const void* data, std::size_t size, std::uint32_t before = 0);

/// Computes the same checksum by a table, without the processor's instruction.
std::uint32_t crc32cByTable(const void* data, std::size_t size, std::uint32_t before = 0);

}  // namespace t4d::platform
