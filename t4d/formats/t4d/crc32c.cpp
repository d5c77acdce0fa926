#include "t4d/formats/t4d/crc32c.h"

#include <algorithm>

#include <isa-l/crc.h>
#ifdef __x86_64__
#include <immintrin.h>
#endif

namespace t4d::formats {
namespace {

// ISA-L 2.30 returns with values in the upper halves of the AVX registers; until they are cleared,
// SSE code on this thread takes several times as long.
#ifdef __x86_64__
[[gnu::target("avx")]] void clearUpperHalves() { _mm256_zeroupper(); }
const bool kHasUpperHalves = __builtin_cpu_supports("avx") != 0;
#else
void clearUpperHalves() {}
constexpr bool kHasUpperHalves = false;
#endif

}  // namespace

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
  if (kHasUpperHalves) clearUpperHalves();
  return ~crc;
}

}  // namespace t4d::formats
