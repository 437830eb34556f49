// Compiled with -mavx2 (no FMA: contraction would change bits); only called where the processor has it.
#include <immintrin.h>

#include "common/cutting/brick_kernel.h"

namespace {

inline __attribute__((always_inline)) __m256 Sqrt8(__m256 v) { return _mm256_sqrt_ps(v); }

#include "common/cutting/brick_kernel.inc"

}  // namespace

namespace enamel::cutting {

BrickChange CutBrickAvx2(const BrickFrame& frame, int16_t* phi, int32_t* gone) noexcept {
  return frame.sphere ? Cut<true>(frame, phi, gone) : Cut<false>(frame, phi, gone);
}

}  // namespace enamel::cutting
