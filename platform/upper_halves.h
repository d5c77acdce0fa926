#pragma once

#ifdef __x86_64__
#include <immintrin.h>
#endif

namespace t4d::platform {

/// To be called after functions of ISA-L 2.30. They leave values in the upper halves of the AVX
/// registers. Until these are cleared, SSE code on this thread takes several times as long.
#ifdef __x86_64__
namespace detail {
[[gnu::target("avx"), gnu::noinline]] inline void clear() { _mm256_zeroupper(); }
inline const bool kHasUpperHalves = __builtin_cpu_supports("avx") != 0;
}  // namespace detail
inline void clearUpperHalves() {
  if (detail::kHasUpperHalves) detail::clear();
}
#else
inline void clearUpperHalves() {}
#endif

}  // namespace t4d::platform
