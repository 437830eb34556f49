// Compiled with -mavx2 (no FMA: contraction would change bits); only called where the processor has
// it.
#include <immintrin.h>

#include "common/cutting/brick_kernel.h"

namespace {

typedef float F8 __attribute__((vector_size(32)));
typedef int32_t I8 __attribute__((vector_size(32)));
typedef int16_t S8 __attribute__((vector_size(16)));
typedef int16_t S16 __attribute__((vector_size(32)));

inline __attribute__((always_inline)) F8 Sqrt8(F8 v) { return (F8)_mm256_sqrt_ps((__m256)v); }
inline __attribute__((always_inline)) S16 Pack(I8 a, I8 b) {
  // The instruction packs within halves of the register: the middle quarters change places.
  return (S16)_mm256_permute4x64_epi64(_mm256_packs_epi32((__m256i)a, (__m256i)b), 0xd8);
}
inline __attribute__((always_inline)) I8 PairSums(S16 v) {
  return (I8)_mm256_madd_epi16((__m256i)v, _mm256_set1_epi16(1));
}
inline __attribute__((always_inline)) int Mask(I8 v) { return _mm256_movemask_ps((__m256)v); }
inline __attribute__((always_inline)) bool All(S16 v) {
  return _mm256_movemask_epi8((__m256i)v) == -1;
}

#include "common/cutting/brick_kernel.inc"

}  // namespace

namespace enamel::cutting {

Kernels Avx2Kernels() noexcept { return {&Cull, &Cut}; }

}  // namespace enamel::cutting
