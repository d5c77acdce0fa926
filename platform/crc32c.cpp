#include "platform/crc32c.h"

#include <array>
#include <bit>
#include <cstring>

#ifdef __x86_64__
#include <immintrin.h>
#endif

namespace t4d::platform {
namespace {

static_assert(std::endian::native == std::endian::little);

/// table[k][b]: what the byte b leaves in the register after k more zero bytes.
using Table = std::array<std::array<std::uint32_t, 256>, 8>;
constexpr Table kTable = [] {
  constexpr std::uint32_t kPolynomial = 0x82F63B78;
  Table table{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? kPolynomial : 0);
    table[0][byte] = crc;
  }
  for (std::size_t k = 1; k < table.size(); ++k) {
    for (std::size_t byte = 0; byte < 256; ++byte) {
      const std::uint32_t before = table[k - 1][byte];
      table[k][byte] = (before >> 8U) ^ table[0][before & 255U];
    }
  }
  return table;
}();

std::uint64_t wordAt(const unsigned char* at) {
  std::uint64_t word = 0;
  std::memcpy(&word, at, sizeof word);
  return word;
}

#ifdef __x86_64__
/// The instruction takes three cycles, and one can begin in each: three runs of bytes at a time.
constexpr std::size_t kRun = 2048;

[[gnu::target("sse4.2,crc32")]] std::uint32_t ofWords(const unsigned char* at, std::size_t bytes,
                                                      std::uint32_t crc) {
  std::uint64_t wide = crc;
  for (std::size_t i = 0; i < bytes; i += 8) wide = _mm_crc32_u64(wide, wordAt(at + i));
  return static_cast<std::uint32_t>(wide);
}

/// What a register is after kRun zero bytes, by its bytes: it is linear in its bits.
using Shift = std::array<std::array<std::uint32_t, 256>, 4>;
[[gnu::target("sse4.2,crc32")]] Shift shiftOfRun() {
  const std::array<unsigned char, kRun> zeros{};
  Shift shift{};
  for (std::uint32_t i = 0; i < 4; ++i) {
    for (std::uint32_t bit = 1; bit < 256; bit *= 2) {
      shift[i][bit] = ofWords(zeros.data(), kRun, bit << 8 * i);
      for (std::uint32_t below = 1; below < bit; ++below) {
        shift[i][bit + below] = shift[i][bit] ^ shift[i][below];
      }
    }
  }
  return shift;
}

[[gnu::target("sse4.2,crc32")]] std::uint32_t byInstruction(const unsigned char* at,
                                                            std::size_t size, std::uint32_t crc) {
  static const Shift shift = shiftOfRun();
  const auto afterRun = [](std::uint32_t one) {
    return shift[0][one & 255U] ^ shift[1][one >> 8U & 255U] ^ shift[2][one >> 16U & 255U] ^
           shift[3][one >> 24U];
  };
  for (; size >= 3 * kRun; size -= 3 * kRun, at += 3 * kRun) {
    std::uint64_t first = crc;
    std::uint64_t second = 0;
    std::uint64_t third = 0;
    for (std::size_t i = 0; i < kRun; i += 8) {
      first = _mm_crc32_u64(first, wordAt(at + i));
      second = _mm_crc32_u64(second, wordAt(at + kRun + i));
      third = _mm_crc32_u64(third, wordAt(at + 2 * kRun + i));
    }
    crc = afterRun(static_cast<std::uint32_t>(first)) ^ static_cast<std::uint32_t>(second);
    crc = afterRun(crc) ^ static_cast<std::uint32_t>(third);
  }
  const std::size_t words = size / 8 * 8;
  crc = ofWords(at, words, crc);
  for (std::size_t i = words; i < size; ++i) crc = _mm_crc32_u8(crc, at[i]);
  return crc;
}
#endif

}  // namespace

std::uint32_t crc32cByTable(const void* data, std::size_t size, std::uint32_t before) {
  const auto* at = static_cast<const unsigned char*>(data);
  std::uint32_t crc = ~before;
  for (; size >= 8; size -= 8, at += 8) {
    const std::uint64_t word = wordAt(at) ^ crc;
    crc = 0;
    for (std::size_t k = 0; k < 8; ++k) crc ^= kTable[7 - k][word >> 8 * k & 255U];
  }
  for (; size > 0; --size) crc = (crc >> 8U) ^ kTable[0][(crc ^ *at++) & 255U];
  return ~crc;
}

std::uint32_t crc32c(const void* data, std::size_t size, std::uint32_t before) {
#ifdef __x86_64__
  static const bool has = __builtin_cpu_supports("sse4.2") != 0;
  if (has) return ~byInstruction(static_cast<const unsigned char*>(data), size, ~before);
#endif
  return crc32cByTable(data, size, before);
}

}  // namespace t4d::platform
