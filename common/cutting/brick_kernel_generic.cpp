#include "common/cutting/brick_kernel.h"

#include <cmath>

namespace {

typedef float Floats __attribute__((vector_size(32)));
inline Floats Sqrt8(Floats v) {
  for (int i = 0; i < 8; ++i) v[i] = std::sqrt(v[i]);
  return v;
}

#include "common/cutting/brick_kernel.inc"

}  // namespace

namespace enamel::cutting {

BrickChange CutBrickGeneric(const BrickFrame& frame, int16_t* phi, int32_t* gone) noexcept {
  return frame.sphere ? Cut<true>(frame, phi, gone) : Cut<false>(frame, phi, gone);
}

#if defined(__x86_64__)
BrickChange CutBrickAvx2(const BrickFrame& frame, int16_t* phi, int32_t* gone) noexcept;
#endif

BrickKernel BestBrickKernel() noexcept {
#if defined(__x86_64__)
  static const BrickKernel kBest = __builtin_cpu_supports("avx2") ? &CutBrickAvx2 : &CutBrickGeneric;
  return kBest;
#else
  return &CutBrickGeneric;
#endif
}

}  // namespace enamel::cutting
