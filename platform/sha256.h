#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace t4d::platform {

/// SHA-256 (FIPS 180-4) of bytes that are added one after another.
class Sha256 {
 public:
  void add(std::span<const std::byte> bytes);
  /// The sum as 64 digits in lower case. Call it once, after all is added.
  std::string finish();

 private:
  void take(const std::byte* block);

  std::array<std::uint32_t, 8> state_ = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                         0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::array<std::byte, 64> block_;  // what waits for the rest of a block
  std::uint64_t size_ = 0;           // of all bytes
};

}  // namespace t4d::platform
